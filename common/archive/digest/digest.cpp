#include "common/archive/digest/digest.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <map>

#include "common/archive/format.h"
#include "common/base/bytes.h"
#include "common/base/check.h"
#include "common/hash/sha256.h"

namespace sleight::archive {
namespace {

constexpr std::uint64_t k_canonical_nan = 0x7ff8000000000000;

std::uint64_t canonical_bits(double value) {
  return std::isnan(value) ? k_canonical_nan : std::bit_cast<std::uint64_t>(value);
}

/// Hashes one dataset's values. The hash doesn't depend on the split into batches.
class ValueHash {
 public:
  void update(const ValuesView& values) {
    std::visit([this](const auto& span) { add(span); }, values);
  }
  std::string finish() { return hash::to_hex(sha_.finish()); }

 private:
  void add(std::span<const double> values) {
    std::array<std::uint64_t, 1024> bits{};
    while (!values.empty()) {
      const std::size_t count = std::min(values.size(), bits.size());
      std::ranges::transform(values.first(count), bits.begin(), canonical_bits);
      sha_.update(base::bytes_of(std::span<const std::uint64_t>(bits).first(count)));
      values = values.subspan(count);
    }
  }
  void add(std::span<const std::string> values) {
    for (const std::string& text : values) {
      const std::array<std::uint64_t, 1> size{text.size()};
      sha_.update(base::bytes_of(std::span<const std::uint64_t>(size)));
      sha_.update(text);
    }
  }
  template <class Integer>
  void add(std::span<const Integer> values) {
    sha_.update(base::bytes_of(values));
  }

  hash::Sha256 sha_;
};

std::string attribute_line(const std::string& object, const Attribute& attribute) {
  struct Printer {
    std::string operator()(std::int64_t value) const { return fmt::format("i64 {}", value); }
    std::string operator()(double value) const {
      return fmt::format("f64 {:016x}", canonical_bits(value));
    }
    std::string operator()(const std::string& value) const {
      return fmt::format("text {}", hash::sha256_hex(value));
    }
  };
  return fmt::format("attribute {} {} {}", object, attribute.name,
                     std::visit(Printer{}, attribute.value));
}

std::string dataset_line(const std::string& path, const DatasetSpec& spec,
                         const std::string& hash) {
  std::string shape;
  for (const Dimension& dim : spec.dims) {
    if (!shape.empty()) shape += ',';
    shape += fmt::format("{}={}", dim.name, dim.size);
  }
  if (shape.empty()) shape = "scalar";
  return fmt::format("dataset {} {} {} {}", path, name_of(spec.type), shape, hash);
}

bool left_out(const Group& group, const Attribute& attribute) {
  return group.name == k_root &&
         (attribute.name == k_content_digest || attribute.name == k_inference_library_version ||
          attribute.name == k_results_version || attribute.name == k_run_id);
}

/// `hash_of(group, spec)` returns the hash of a dataset's values.
template <class HashOf>
std::string manifest_of(const std::vector<Group>& groups, HashOf&& hash_of) {
  std::vector<std::string> lines;
  for (const Group& group : groups) {
    lines.push_back("group " + group.name);
    for (const Attribute& attribute : group.attributes) {
      if (!left_out(group, attribute)) lines.push_back(attribute_line(group.name, attribute));
    }
    for (const DatasetSpec& spec : group.datasets) {
      const std::string path = path_of(group.name, spec.name);
      for (const Attribute& attribute : spec.attributes) {
        lines.push_back(attribute_line(path, attribute));
      }
      lines.push_back(dataset_line(path, spec, hash_of(group, spec)));
    }
  }
  std::ranges::sort(lines);
  std::string text = fmt::format("{} digest 1\n", k_format_name);
  for (const std::string& line : lines)
    text.append(line).append("\n");
  return text;
}

std::string hash_of_dataset(const Source& source, const Group& group, const DatasetSpec& spec) {
  ValueHash hash;
  const std::uint64_t total = element_count(spec);
  for (std::uint64_t first = 0; first < total; first += k_batch_elements) {
    const std::uint64_t count = std::min<std::uint64_t>(k_batch_elements, total - first);
    const Values values = source.read(group.name, spec.name, first, count);
    hash.update(view_of(values));
  }
  return hash.finish();
}

/// Forwards an archive to another sink, checks model.h's invariants and hashes the values.
class DigestingSink final : public Sink {
 public:
  explicit DigestingSink(Sink& next) : next_(next), groups_{Group{.name = std::string(k_root)}} {}

  void create_group(std::string_view name) override {
    CHECK(name.starts_with('/') && is_plain_name(name.substr(1)));
    CHECK(std::ranges::find(groups_, name, &Group::name) == groups_.end());
    groups_.push_back({.name = std::string(name)});
    next_.create_group(name);
  }

  void set_attribute(std::string_view group_name, const Attribute& attribute) override {
    Group& group = groups_[index_of(group_name)];
    check_attribute(group.attributes, attribute);
    group.attributes.push_back(attribute);
    next_.set_attribute(group_name, attribute);
  }

  DatasetHandle create_dataset(std::string_view group_name, const DatasetSpec& spec) override {
    const std::size_t group = index_of(group_name);
    check_spec(groups_[group], spec);
    groups_[group].datasets.push_back(spec);
    written_.push_back({.group = group, .dataset = groups_[group].datasets.size() - 1});
    CHECK_EQ(next_.create_dataset(group_name, spec), written_.size() - 1);
    return written_.size() - 1;
  }

  void append(DatasetHandle dataset, const ValuesView& values) override {
    CHECK_LT(dataset, written_.size());
    Written& written = written_[dataset];
    const DatasetSpec& spec = groups_[written.group].datasets[written.dataset];
    CHECK_EQ(static_cast<int>(spec.type), static_cast<int>(type_of(values)));
    if (const auto* texts = std::get_if<std::span<const std::string>>(&values)) {
      for (const std::string& text : *texts) {
        CHECK_LE(text.size(), spec.text_bytes);
        CHECK(text.find('\0') == std::string::npos);
      }
    }
    written.elements += count_of(values);
    written.hash.update(values);
    next_.append(dataset, values);
  }

  void finish() override { base::check_failed("only write_digested finishes the sink", ""); }

  /// REQUIRES: all values have been written.
  std::string close() {
    std::map<std::string, std::string> hashes;
    for (Written& written : written_) {
      Group& group = groups_[written.group];
      DatasetSpec& spec = group.datasets[written.dataset];
      settle_size(spec, written.elements);
      hashes[path_of(group.name, spec.name)] = written.hash.finish();
    }
    for (const Group& group : groups_)
      check_coordinates(group);
    return hash::sha256_hex(
        manifest_of(groups_, [&hashes](const Group& group, const DatasetSpec& spec) {
          return hashes.at(path_of(group.name, spec.name));
        }));
  }

 private:
  struct Written {
    std::size_t group = 0;
    std::size_t dataset = 0;
    std::uint64_t elements = 0;
    ValueHash hash{};
  };

  std::size_t index_of(std::string_view name) const {
    const auto found = std::ranges::find(groups_, name, &Group::name);
    CHECK(found != groups_.end());
    return static_cast<std::size_t>(found - groups_.begin());
  }

  static void check_attribute(const std::vector<Attribute>& others, const Attribute& attribute) {
    CHECK(is_plain_name(attribute.name));
    CHECK(find_attribute(others, attribute.name) == nullptr);
    if (const auto* text = std::get_if<std::string>(&attribute.value)) {
      CHECK(text->find('\0') == std::string::npos);
    }
  }

  static void check_spec(const Group& group, const DatasetSpec& spec) {
    CHECK(is_plain_name(spec.name));
    CHECK(find_dataset(group, spec.name) == nullptr);
    CHECK_LE(spec.dims.size(), k_rank_max);
    for (std::size_t i = 0; i < spec.dims.size(); ++i) {
      CHECK(is_plain_name(spec.dims[i].name));
      CHECK(i == 0 || spec.dims[i].size != k_growing);
    }
    std::vector<Attribute> before;
    for (const Attribute& attribute : spec.attributes) {
      check_attribute(before, attribute);
      before.push_back(attribute);
    }
  }

  static void settle_size(DatasetSpec& spec, std::uint64_t elements) {
    if (!spec.dims.empty() && spec.dims.front().size == k_growing) {
      spec.dims.front().size = 1;
      const std::uint64_t row = element_count(spec);
      spec.dims.front().size = row == 0 ? 0 : elements / row;
    }
    CHECK_EQ(element_count(spec), elements);
  }

  static void check_coordinates(const Group& group) {
    for (const DatasetSpec& spec : group.datasets) {
      for (const Dimension& dim : spec.dims) {
        const DatasetSpec* coordinate = find_dataset(group, dim.name);
        if (coordinate == nullptr || coordinate->dims.size() != 1 ||
            coordinate->dims[0].name != dim.name || coordinate->dims[0].size != dim.size) {
          base::check_failed("every dimension has a coordinate of the same size",
                             path_of(group.name, spec.name) + " " + dim.name);
        }
      }
    }
  }

  Sink& next_;
  std::vector<Group> groups_;
  std::vector<Written> written_;  ///< by handle
};

}  // namespace

std::string manifest(const Source& source) {
  return manifest_of(source.groups(), [&source](const Group& group, const DatasetSpec& spec) {
    return hash_of_dataset(source, group, spec);
  });
}

std::string digest(const Source& source) {
  return hash::sha256_hex(manifest(source));
}

std::string write_digested(Sink& sink, const std::function<void(Sink&)>& fill) {
  DigestingSink digesting(sink);
  fill(digesting);
  const std::string hex = digesting.close();
  sink.set_attribute(k_root, {std::string(k_content_digest), hex});
  sink.finish();
  return hex;
}

}  // namespace sleight::archive
