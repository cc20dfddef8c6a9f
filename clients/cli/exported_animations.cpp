#include "clients/cli/exported_animations.h"

#include <algorithm>
#include <ostream>
#include <sstream>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "clients/analysis/archive_rows.h"
#include "clients/browse/archives/kept_animations.h"
#include "clients/browse/reading.h"
#include "clients/terminal/interruption.h"
#include "common/archive/csv.h"
#include "common/archive/format.h"
#include "common/archive/kept_motions.h"
#include "common/archive/summary.h"
#include "common/base/check.h"

namespace sleight::cli {
namespace {

/// Splits a line of CSV into fields and keeps their quotes.
std::vector<std::string> fields_of(const std::string& line) {
  std::vector<std::string> fields(1);
  bool is_quoted = false;
  for (const char letter : line) {
    if (letter == '"') is_quoted = !is_quoted;
    if (letter == ',' && !is_quoted) {
      fields.emplace_back();
    } else {
      fields.back() += letter;
    }
  }
  return fields;
}

struct CsvRows {
  std::vector<std::string> columns{};
  std::stringstream lines{};
  std::vector<std::uint64_t> counts{};  ///< lines per animation
};

/// REQUIRES: all ids belong to one group. No ids: no columns.
CsvRows rows_of(const archive::Source& source, std::span<const browse::AnimationId> ids,
                const std::string& table) {
  CsvRows rows;
  if (ids.empty()) return rows;
  std::vector<std::uint64_t> numbers;
  for (const browse::AnimationId& id : ids)
    numbers.push_back(id.row);
  std::string in_archive = table;
  if (ids.front().is_find) in_archive = table == "animations" ? "finds" : "find_" + table;
  archive::export_csv(source, in_archive, rows.lines, numbers);
  // No field contains a line break: in an archive, only the request has line breaks.
  std::string header;
  std::getline(rows.lines, header);
  rows.columns = fields_of(header);
  rows.counts.assign(ids.size(), 1);
  if (table == "animations") return rows;
  const std::string column = table == "segments" ? "segment_count" : "point_count";
  for (std::size_t i = 0; i < ids.size(); ++i) {
    const double count =
        analysis::read_rows(source, group_of(ids[i]), column, 1, {.first = ids[i].row, .count = 1})
            .front();
    rows.counts[i] = count > 0 ? static_cast<std::uint64_t>(count) : 0;
  }
  return rows;
}

/// Returns the lines of the nth animation. REQUIRES: animations are read in order.
std::vector<std::string> lines_of(CsvRows& rows, std::size_t nth) {
  std::vector<std::string> lines;
  std::string line;
  for (std::uint64_t row = 0; row < rows.counts[nth] && std::getline(rows.lines, line); ++row)
    lines.push_back(line);
  return lines;
}

/// Returns the positions of these columns among all columns. REQUIRES: `all` contains them.
std::vector<std::size_t> places_in(std::span<const std::string> some,
                                   std::span<const std::string> all) {
  std::vector<std::size_t> places;
  for (const std::string& column : some)
    places.push_back(static_cast<std::size_t>(std::ranges::find(all, column) - all.begin()));
  return places;
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
                   const browse::AnimationId& id) {
  const std::string_view group_name = group_of(id);
  const archive::KeptMotions motions(source, group_name);
  browse::KeptAnimation kept = browse::kept_animation(source, motions, id.row, scene, id.text);
  gltf::Clip clip{.name = id.text,
                  .motion = std::move(kept.motion),
                  .own = std::move(kept.own),
                  .offsets_m = std::move(kept.offsets_m),
                  .extras = {{"id", id.text}}};
  const auto whole = [&](const char* name) {
    const double number =
        analysis::read_rows(source, group_name, name, 1, {.first = id.row, .count = 1})[0];
    clip.extras.push_back({name, static_cast<std::int64_t>(number)});
  };
  if (id.is_find) {
    whole("start");
  } else {
    for (const char* name : {"chain", "draw", "lineage"})
      whole(name);
  }
  clip.extras.push_back({"in_proportion", motions.in_proportion(id.row)});
  clip.extras.push_back({"duration_s", clip.motion.end_s()});
  // If /sample_stats also contains a number, it is a density or an outcome. Other numbers belong to
  // the state.
  const archive::Group* group = archive::find_group(source, group_name);
  const archive::Group* stats = archive::find_group(source, archive::k_sample_stats);
  for (const archive::DatasetSpec& spec : group->datasets) {
    if (spec.type != archive::ElementType::f64 || spec.dims.empty() ||
        spec.dims[0].name != "animation" || stats == nullptr ||
        archive::find_dataset(*stats, spec.name) == nullptr)
      continue;
    std::uint64_t width = 1;
    for (const archive::Dimension& dim : std::span(spec.dims).subspan(1))
      width = std::min(width * std::min<std::uint64_t>(dim.size, browse::k_number_elements_max + 1),
                       browse::k_number_elements_max + 1);
    if (width > browse::k_number_elements_max) continue;
    std::vector<double> values =
        analysis::read_rows(source, group_name, spec.name, width, {.first = id.row, .count = 1});
    // A world's outcome may have the same name as one of the keys above.
    const bool is_taken = std::ranges::count(clip.extras, spec.name, &gltf::Extra::key) > 0;
    const std::string key = (is_taken ? "outcome_" : "") + spec.name;
    if (spec.dims.size() == 1) {
      clip.extras.push_back({key, values.front()});
    } else {
      clip.extras.push_back({key, std::move(values)});
    }
  }
  return clip;
}

void write_animations_csv(const archive::Source& source, std::span<const browse::AnimationId> ids,
                          const std::string& table, std::ostream& out) {
  CHECK(!ids.empty());
  std::vector<browse::AnimationId> of_chains;
  std::vector<browse::AnimationId> finds;
  for (const browse::AnimationId& id : ids)
    (id.is_find ? finds : of_chains).push_back(id);
  CsvRows from_chains = rows_of(source, of_chains, table);
  CsvRows from_finds = rows_of(source, finds, table);

  // First come the columns of chains, then the columns that only finds have.
  std::vector<std::string> columns = from_chains.columns;
  for (const std::string& column : from_finds.columns) {
    if (std::ranges::count(columns, column) == 0) columns.push_back(column);
  }
  out << fmt::format("id,{}\n", fmt::join(columns, ","));

  // Write rows in the requested order.
  const std::vector<std::size_t> places_of_chains = places_in(from_chains.columns, columns);
  const std::vector<std::size_t> places_of_finds = places_in(from_finds.columns, columns);
  std::size_t next_of_chains = 0;
  std::size_t next_of_finds = 0;
  for (const browse::AnimationId& id : ids) {
    terminal::Interruption::check();
    CsvRows& rows = id.is_find ? from_finds : from_chains;
    std::size_t& nth = id.is_find ? next_of_finds : next_of_chains;
    for (const std::string& line : lines_of(rows, nth++)) {
      std::vector<std::string> fields(columns.size());
      const std::vector<std::size_t>& places = id.is_find ? places_of_finds : places_of_chains;
      std::size_t column = 0;
      for (std::string& field : fields_of(line)) {
        if (column < places.size()) fields[places[column++]] = std::move(field);
      }
      out << fmt::format("{},{}\n", id.text, fmt::join(fields, ","));
    }
  }
}

}  // namespace sleight::cli
