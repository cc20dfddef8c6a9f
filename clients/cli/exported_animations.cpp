#include "clients/cli/exported_animations.h"

#include <algorithm>
#include <ostream>
#include <sstream>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "clients/cli/kept_animations.h"
#include "clients/cli/trace.h"
#include "common/archive/csv.h"
#include "common/archive/format.h"
#include "common/archive/kept_motions.h"
#include "common/archive/summary.h"
#include "common/base/check.h"
#include "common/base/error.h"

namespace sleight::cli {
namespace {

/// Outcomes of more elements are no metadata.
constexpr std::uint64_t k_outcome_elements_max = 64;

[[noreturn]] void refuse(const archive::Source& source, const AnimationId& id,
                         std::string_view reason) {
  throw base::Error(base::ExitCode::bad_archive,
                    fmt::format("{}: its animation {} {}", source.name(), id.text, reason));
}

/// The rows of the table of each animation, so that each has its id.
std::vector<std::uint64_t> rows_of_each(const archive::Source& source,
                                        std::span<const AnimationId> ids,
                                        const std::string& table) {
  std::vector<std::uint64_t> counts(ids.size(), 1);
  if (table == "animations") return counts;
  const std::string column = table == "segments" ? "segment_count" : "point_count";
  for (std::size_t i = 0; i < ids.size(); ++i) {
    const double count =
        read_rows(source, group_of(ids[i]), column, 1, {.first = ids[i].row, .count = 1}).front();
    counts[i] = count > 0 ? static_cast<std::uint64_t>(count) : 0;
  }
  return counts;
}

}  // namespace

gltf::Extras extras_of(const archive::Source& source) {
  const archive::Summary summary = archive::summary_of(source);
  gltf::Extras extras{{"world", summary.world},
                      {"run_id", summary.run_id},
                      {"results_version", summary.results_version}};
  if (!summary.warning.empty()) extras.push_back({"warning", summary.warning});
  extras.push_back({"request", summary.request_text});
  return extras;
}

gltf::Clip clip_of(const archive::Source& source, const scene::Scene& scene,
                   const AnimationId& id) {
  const std::string_view group_name = group_of(id);
  const archive::KeptMotions motions(source, group_name);
  auto motion = motions.animation(id.row, scene);
  if (!motion) refuse(source, id, motion.error());
  auto own = motions.variation(id.row, scene);
  if (!own) refuse(source, id, own.error());
  gltf::Clip clip{.name = id.text,
                  .motion = std::move(motion).value(),
                  .own = std::move(own).value(),
                  .offsets_m = motions.offsets_m(id.row, scene),
                  .extras = {{"id", id.text}}};
  const auto whole = [&](const char* name) {
    const double number = read_rows(source, group_name, name, 1, {.first = id.row, .count = 1})[0];
    clip.extras.push_back({name, static_cast<std::int64_t>(number)});
  };
  if (id.is_find) {
    whole("start");
  } else {
    for (const char* name : {"chain", "draw", "lineage"})
      whole(name);
  }
  clip.extras.push_back({"in_proportion", motions.in_proportion(id.row)});
  clip.extras.push_back({"end_s", clip.motion.end_s()});
  // Densities and outcomes are what scans have too; all else of an animation is its state.
  const archive::Group* group = archive::find_group(source, group_name);
  const archive::Group* stats = archive::find_group(source, archive::k_sample_stats);
  for (const archive::DatasetSpec& spec : group->datasets) {
    if (spec.type != archive::ElementType::f64 || spec.dims.empty() ||
        spec.dims[0].name != "animation" || stats == nullptr ||
        archive::find_dataset(*stats, spec.name) == nullptr)
      continue;
    std::uint64_t width = 1;
    for (const archive::Dimension& dim : std::span(spec.dims).subspan(1))
      width = std::min(width * std::min<std::uint64_t>(dim.size, k_outcome_elements_max + 1),
                       k_outcome_elements_max + 1);
    if (width > k_outcome_elements_max) continue;
    std::vector<double> values =
        read_rows(source, group_name, spec.name, width, {.first = id.row, .count = 1});
    if (spec.dims.size() == 1) {
      clip.extras.push_back({spec.name, values.front()});
    } else {
      clip.extras.push_back({spec.name, std::move(values)});
    }
  }
  return clip;
}

void write_animations_csv(const archive::Source& source, std::span<const AnimationId> ids,
                          const std::string& table, std::ostream& out) {
  CHECK(!ids.empty());
  const bool are_finds = ids.front().is_find;
  if (!std::ranges::all_of(ids, [&](const AnimationId& id) { return id.is_find == are_finds; })) {
    throw base::Error(base::ExitCode::usage,
                      fmt::format("{}: finds have other columns than animations of chains; write "
                                  "a table of each with --ids",
                                  source.name()));
  }
  std::string in_archive = table;
  if (are_finds) in_archive = table == "animations" ? "finds" : "find_" + table;
  std::vector<std::uint64_t> rows;
  for (const AnimationId& id : ids)
    rows.push_back(id.row);
  // No field holds a line's end: archives have none in text but requests.
  std::stringstream lines;
  archive::export_csv(source, in_archive, lines, rows);
  std::string line;
  std::getline(lines, line);
  out << "id," << line << '\n';
  const std::vector<std::uint64_t> counts = rows_of_each(source, ids, table);
  for (std::size_t i = 0; i < ids.size(); ++i) {
    for (std::uint64_t row = 0; row < counts[i] && std::getline(lines, line); ++row)
      out << ids[i].text << ',' << line << '\n';
  }
}

}  // namespace sleight::cli
