#include "clients/browse/reading.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <set>
#include <span>
#include <string_view>
#include <tuple>
#include <utility>
#include <variant>

#include <fmt/format.h>

#include "common/archive/format.h"
#include "common/archive/kept_motions.h"
#include "common/archive/summary.h"
#include "common/base/error.h"
#include "common/motion/path.h"

namespace sleight::browse {
namespace {

/// Animations between two progress reports.
constexpr std::uint64_t k_report_every = 64;
/// Maximum animations of a group, more than any request may store.
constexpr std::uint64_t k_animations_max = 10'000'000;

/// Datasets over `animation` that are unused, or are read separately from an entry's other numbers.
constexpr std::array<std::string_view, 14> k_no_numbers{
    "animation",  "chain",          "draw",          "lineage",       "in_proportion",
    "log_prior",  "log_constraint", "segment_start", "segment_count", "part_start",
    "part_count", "point_start",    "point_count",   "start"};

std::vector<double> as_numbers(archive::Values values) {
  return std::visit(
      [](auto&& held) -> std::vector<double> {
        using Element = typename std::decay_t<decltype(held)>::value_type;
        if constexpr (std::is_same_v<Element, std::string>) {
          return {};
        } else {
          return {held.begin(), held.end()};
        }
      },
      std::move(values));
}

struct NumberColumn {
  std::string dataset;
  std::uint64_t width = 1;  ///< elements per animation
};

class GroupReader {
 public:
  GroupReader(const archive::Source& source, std::string_view group, Index& index)
      : source_(source),
        group_(group),
        spec_(*archive::find_group(source, group)),
        is_finds_(group == archive::k_finds),
        motions_(source, group),
        index_(index) {
    if (motions_.count() > k_animations_max)
      throw base::Error(base::ExitCode::bad_archive, fmt::format("{}: has more than {} animations",
                                                                 source.name(), k_animations_max));
  }

  std::uint64_t count() const { return motions_.count(); }
  bool is_finds() const { return is_finds_; }

  /// Names the numbers of animations. Both groups have the same numbers, so the group that is read
  /// first determines them.
  void find_numbers() {
    for (const archive::DatasetSpec& dataset : spec_.datasets) {
      const bool is_number = dataset.type != archive::ElementType::text && !dataset.dims.empty() &&
                             dataset.dims[0].name == "animation" &&
                             std::ranges::find(k_no_numbers, dataset.name) == k_no_numbers.end() &&
                             elements_of(dataset) <= k_number_elements_max;
      if (!is_number) continue;
      const archive::Attribute* unit = archive::find_attribute(dataset.attributes, "units");
      const auto* text = unit == nullptr ? nullptr : std::get_if<std::string>(&unit->value);
      for (std::uint64_t element = 0; element < elements_of(dataset); ++element)
        index_.numbers.push_back(
            {.name = dataset.name + element_text(dataset, element), .unit = text ? *text : "1"});
    }
  }

  void read_tables() {
    const std::uint64_t animations = count();
    const auto rows = static_cast<double>(animations);
    require_at_most(rows * index_.scene.bodies(), k_browsed_bodies_max, "bodies");
    require_at_most(rows * static_cast<double>(index_.numbers.size()), k_browsed_numbers_max,
                    "numbers");
    const auto column = [&](const char* name) {
      return as_numbers(source_.read(group_, name, 0, animations));
    };
    log_prior_ = column("log_prior");
    log_constraint_ = column("log_constraint");
    in_proportion_ = column("in_proportion");
    segment_count_ = column("segment_count");
    double segments = 0;
    for (const double count : segment_count_)
      segments += count;
    require_at_most(segments, k_browsed_segments_max, "segments");
    if (!is_finds_) {
      chain_ = whole("chain");
      draw_ = whole("draw");
      lineage_ = whole("lineage");
    }
    for (std::size_t number = k_own_numbers; number < index_.numbers.size();) {
      const std::string& name = index_.numbers[number].name;
      const std::string dataset = name.substr(0, name.find('['));
      const archive::DatasetSpec* spec = archive::find_dataset(spec_, dataset);
      std::size_t width = 1;
      while (number + width < index_.numbers.size() &&
             index_.numbers[number + width].name.starts_with(dataset + "["))
        ++width;
      const bool is_here = spec != nullptr && spec->type != archive::ElementType::text &&
                           !spec->dims.empty() && spec->dims[0].size == animations &&
                           elements_of(*spec) == width;
      numbers_.emplace_back(
          width, is_here ? as_numbers(source_.read(group_, dataset, 0, animations * width))
                         : std::vector<double>{});
      number += width;
    }
  }

  AnimationName name_of(std::uint64_t row) const {
    if (is_finds_) return {.run = index_.run_id, .is_find = true, .draw = row};
    return {.run = index_.run_id,
            .chain = static_cast<std::uint64_t>(chain_[row]),
            .draw = static_cast<std::uint64_t>(draw_[row])};
  }

  /// Whether an earlier archive's entry equals this row: same name, same numbers and the same
  /// number of segments.
  bool is_same(const Entry& earlier, std::uint64_t row) const {
    const Entry entry = without_motion(row);
    const auto is_equal = [](double x, double y) {
      return x == y || (std::isnan(x) && std::isnan(y));
    };
    if (entry.name != earlier.name || entry.lineage != earlier.lineage ||
        entry.in_proportion != earlier.in_proportion || entry.row != earlier.row ||
        earlier.numbers.size() != entry.numbers.size() ||
        earlier.pieces.size() != static_cast<std::size_t>(segment_count_[row]))
      return false;
    for (std::size_t i = 0; i < entry.numbers.size(); ++i) {
      // rest_s and events come from the motion, which isn't read yet.
      if (i != k_rest_s && i != k_events && !is_equal(entry.numbers[i], earlier.numbers[i]))
        return false;
    }
    return true;
  }

  Entry entry(std::uint64_t row) const {
    Entry entry = without_motion(row);
    auto motion = motions_.animation(row, index_.scene);
    if (!motion)
      throw base::Error(base::ExitCode::bad_archive,
                        fmt::format("{}: animation {} {}", source_.name(), short_text(entry.name),
                                    motion.error()));
    add_motion(motion.value(), entry);
    return entry;
  }

 private:
  static std::uint64_t elements_of(const archive::DatasetSpec& dataset) {
    std::uint64_t elements = 1;
    for (std::size_t i = 1; i < dataset.dims.size(); ++i) {
      elements *= dataset.dims[i].size;
      if (elements > k_number_elements_max) return elements;
    }
    return elements;
  }

  /// Returns "[2]" or "[1,0]", counted from 0 as in the archive; "" for a scalar.
  static std::string element_text(const archive::DatasetSpec& dataset, std::uint64_t element) {
    std::string text;
    for (std::size_t i = dataset.dims.size() - 1; i >= 1; --i) {
      const std::uint64_t size = dataset.dims[i].size;
      text = fmt::format("{}{}{}", element % size, text.empty() ? "" : ",", text);
      element /= size;
    }
    return text.empty() ? text : "[" + text + "]";
  }

  /// Reads integers, which must not be negative.
  std::vector<std::int64_t> whole(const char* name) const {
    auto values = std::get<std::vector<std::int64_t>>(source_.read(group_, name, 0, count()));
    if (std::ranges::any_of(values, [](std::int64_t value) { return value < 0; })) {
      throw base::Error(base::ExitCode::bad_archive, fmt::format("{}: {}/{} has a number below 0",
                                                                 source_.name(), group_, name));
    }
    return values;
  }

  void require_at_most(double count, double most, const char* of_what) const {
    if (count <= most) return;
    throw base::Error(base::ExitCode::bad_archive,
                      fmt::format("{}: the animations have {:.0f} {}, above the maximum of {:.0f}",
                                  source_.name(), count, of_what, most));
  }

  Entry without_motion(std::uint64_t row) const {
    Entry entry{.name = name_of(row),
                .row = row,
                .lineage = is_finds_ ? 0 : lineage_[row],
                .in_proportion = in_proportion_[row] == 1};
    entry.numbers = {log_prior_[row],
                     log_constraint_[row],
                     static_cast<double>(entry.name.chain),
                     static_cast<double>(entry.name.draw),
                     static_cast<double>(entry.lineage),
                     0,
                     0,
                     entry.in_proportion ? 1.0 : 0.0};
    for (const auto& [width, values] : numbers_) {
      for (std::size_t i = 0; i < width; ++i)
        entry.numbers.push_back(values.empty() ? std::numeric_limits<double>::quiet_NaN()
                                               : values[row * width + i]);
    }
    return entry;
  }

  static void add_motion(const motion::Animation& motion, Entry& entry) {
    entry.pieces.reserve(motion.segment_count());
    for (const motion::Path& path : motion.paths()) {
      entry.tracks.push_back({.first = static_cast<std::uint32_t>(entry.pieces.size()),
                              .count = static_cast<std::uint32_t>(path.segments().size())});
      for (const motion::Segment& segment : path.segments()) {
        entry.pieces.push_back({.start_s = segment.start_s,
                                .position_m = segment.position_m,
                                .velocity_mps = segment.velocity_mps,
                                .acceleration_mps2 = segment.acceleration_mps2});
        if (segment.cause != motion::Cause::start) ++entry.events;
        if (segment.partner == motion::k_no_partner) continue;
        entry.contacts.push_back({.time_s = segment.start_s,
                                  .body = path.body(),
                                  .partner = static_cast<std::uint32_t>(segment.partner)});
      }
    }
    std::ranges::sort(entry.contacts, {}, [](const Contact& contact) {
      return std::tuple(contact.time_s, contact.body, contact.partner);
    });
    measure_reach(entry);
    entry.end_s = motion.end_s();
    entry.numbers[k_rest_s] = entry.end_s;
    entry.numbers[k_events] = entry.events;
  }

  const archive::Source& source_;
  std::string group_;
  const archive::Group& spec_;
  bool is_finds_;
  archive::KeptMotions motions_;
  Index& index_;
  std::vector<double> log_prior_{};
  std::vector<double> log_constraint_{};
  std::vector<double> in_proportion_{};
  std::vector<double> segment_count_{};
  std::vector<std::int64_t> chain_{};
  std::vector<std::int64_t> draw_{};
  std::vector<std::int64_t> lineage_{};
  /// Width and values of each dataset of numbers. Values are empty if this group lacks the dataset.
  std::vector<std::pair<std::size_t, std::vector<double>>> numbers_{};
};

/// Returns the earlier index's entries of chains, or of finds.
std::span<const Entry> earlier_entries(const Index* earlier, bool is_finds) {
  if (earlier == nullptr) return {};
  const auto first_find =
      std::ranges::find_if(earlier->entries, [](const Entry& entry) { return entry.name.is_find; });
  return is_finds ? std::span(first_find, earlier->entries.end())
                  : std::span(earlier->entries.begin(), first_find);
}

/// Whether the earlier index has the same run, world and numbers, and refers only to bodies and
/// features that the scene has.
bool is_usable(const Index& earlier, const Index& index) {
  const std::uint32_t bodies = index.scene.bodies();
  const auto fits = [&](const Entry& entry) {
    return entry.tracks.size() == bodies &&
           std::ranges::all_of(entry.contacts, [&](const Contact& contact) {
             return contact.body < bodies && contact.partner < index.scene.features.size();
           });
  };
  return earlier.run_id == index.run_id && earlier.world == index.world &&
         earlier.numbers == index.numbers && std::ranges::all_of(earlier.entries, fits);
}

}  // namespace

base::Result<ReadIndex, std::string> read_index(const archive::Source& source,
                                                const ReadingOptions& options) {
  auto scene = archive::scene_of(source);
  if (!scene) return scene.error();
  const archive::Summary summary = archive::summary_of(source);
  ReadIndex read;
  Index& index = read.index;
  index.run_id = summary.run_id;
  index.digest = summary.content_digest;
  index.world = summary.world;
  index.scene = std::move(scene).value();
  index.numbers = own_numbers();

  std::vector<GroupReader> groups;
  std::uint64_t total = 0;
  for (const std::string_view group : {archive::k_animations, archive::k_finds}) {
    if (archive::find_group(source, group) == nullptr) continue;
    groups.emplace_back(source, group, index);
    if (index.numbers.size() == k_own_numbers) groups.back().find_numbers();
    total += groups.back().count();
  }
  const Index* earlier = options.of_this_file != nullptr ? options.of_this_file : options.earlier;
  if (earlier != nullptr && !is_usable(*earlier, index)) earlier = nullptr;
  if (earlier != nullptr && earlier->digest == index.digest) {
    if (options.of_this_file != nullptr && earlier->entries.size() == total) {
      index.entries = std::move(options.of_this_file->entries);
      read.taken_over = total;
      return read;
    }
    earlier = nullptr;
  }
  if (options.beginning_max > 0 && total > options.beginning_max && earlier == nullptr) {
    read.is_beginning = true;
    total = options.beginning_max;
  }

  for (GroupReader& group : groups) {
    group.read_tables();
    const auto before = earlier_entries(earlier, group.is_finds());
    // A run's longer archive usually begins with the animations of its shorter archives. Otherwise
    // nothing is reused.
    const std::uint64_t common = std::min<std::uint64_t>(before.size(), group.count());
    bool is_beginning = true;
    for (std::uint64_t row = 0; is_beginning && row < common; ++row)
      is_beginning = group.is_same(before[row], row);
    const std::uint64_t rows = std::min(group.count(), total - index.entries.size());
    for (std::uint64_t row = 0; row < rows; ++row) {
      if (is_beginning && row < common) {
        index.entries.push_back(before[row]);
        ++read.taken_over;
      } else {
        index.entries.push_back(group.entry(row));
      }
      if (options.progress && (row % k_report_every == 0 || index.entries.size() == total))
        options.progress(index.entries.size(), total);
    }
  }
  std::set<AnimationName> names;
  for (const Entry& entry : index.entries) {
    if (!names.insert(entry.name).second) {
      throw base::Error(
          base::ExitCode::bad_archive,
          fmt::format("{}: two animations have the id {}", source.name(), short_text(entry.name)));
    }
  }
  return read;
}

}  // namespace sleight::browse
