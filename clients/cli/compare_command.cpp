#include "clients/cli/compare_command.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "clients/analysis/comparison.h"
#include "clients/browse/archives/browsed.h"
#include "clients/browse/groups.h"
#include "clients/cli/browsed_json.h"
#include "clients/cli/groups_command.h"
#include "clients/report/text_table.h"
#include "clients/terminal/output.h"
#include "clients/terminal/terminal.h"
#include "common/archive/remote/remote_source.h"
#include "common/archive/summary.h"
#include "common/base/cores.h"
#include "common/base/error.h"
#include "common/json/value.h"

namespace sleight::cli {
namespace {

constexpr std::size_t k_lines_shown_max = 40;

struct ComparedGroup {
  std::string representative;
  std::array<std::size_t, 2> members{};
};

struct Comparison {
  std::array<std::size_t, 2> animations{};
  std::vector<analysis::OtherLine> request;
  std::vector<analysis::ComparedNumber> numbers;
  std::string why_no_groups;  ///< empty: groups and a test exist
  std::vector<ComparedGroup> groups;
  analysis::ComparedLooks looks{};
};

std::string request_of(const std::string& path) {
  return archive::summary_of(*archive::remote::open_remote(path)).request_text;
}

void compare_looks(const browse::Browsed& browsed, std::size_t groups, Comparison& comparison) {
  const auto& archives = browsed.archives;
  const scene::Scene& scene = archives[0].index.scene;
  if (!browse::are_comparable(scene, archives[1].index.scene)) {
    comparison.why_no_groups = "the archives have different bodies";
    return;
  }
  std::vector<browse::Picked> all;
  std::array<std::vector<const browse::Entry*>, 2> sets;
  for (std::size_t set = 0; set < 2; ++set) {
    for (const browse::Entry& entry : archives[set].index.entries) {
      all.push_back({.archive = &archives[set], .entry = &entry});
      sets.at(set).push_back(&entry);
    }
  }
  if (sets[0].empty() || sets[1].empty()) {
    comparison.why_no_groups = archives[1].twice > 0 && sets[1].empty()
                                   ? "all animations of the second archive are in the first"
                                   : "one of the archives has no animations";
    return;
  }
  const auto& found = groups_of(all, groups, browse::Grouping::medoids);
  for (const browse::AlikeGroup& group : found.groups) {
    ComparedGroup compared{.representative =
                               name_among(browsed, all[group.representative].entry->name)};
    for (const std::size_t member : group.members)
      ++compared.members[all[member].archive == &archives[0] ? 0 : 1];
    comparison.groups.push_back(std::move(compared));
  }
  comparison.looks = analysis::compared_looks(sets, scene, base::cores_here());
}

Json spread_json(const analysis::Spread& spread) {
  if (spread.count == 0) return {{"count", 0}};
  return {{"count", spread.count},
          {"mean", spread.mean},
          {"sd", spread.sd},
          {"least", spread.least},
          {"most", spread.most}};
}

Json comparison_json(const browse::Browsed& browsed, const Comparison& comparison) {
  Json json = archives_json(browsed);
  json["request"] = Json::array();
  for (const analysis::OtherLine& line : comparison.request) {
    const auto value = [](const std::string& text) { return text.empty() ? Json() : Json(text); };
    json["request"].push_back(
        {{"key", line.key}, {"first", value(line.first)}, {"second", value(line.second)}});
  }
  json["numbers"] = Json::array();
  for (const analysis::ComparedNumber& number : comparison.numbers)
    json["numbers"].push_back({{"name", number.name},
                               {"first", spread_json(number.of[0])},
                               {"second", spread_json(number.of[1])}});
  json["groups"] = Json::array();
  for (const ComparedGroup& group : comparison.groups)
    json["groups"].push_back({{"representative", group.representative},
                              {"first", group.members[0]},
                              {"second", group.members[1]}});
  if (comparison.why_no_groups.empty()) {
    json["nearest_neighbours"] = {{"tested_first", comparison.looks.tested[0]},
                                  {"tested_second", comparison.looks.tested[1]},
                                  {"share_same", comparison.looks.test.share},
                                  {"expected", comparison.looks.test.expected},
                                  {"p_value", comparison.looks.test.p_value}};
  } else {
    json["not_compared"] = comparison.why_no_groups;
  }
  return json;
}

void print_requests(const std::vector<analysis::OtherLine>& lines) {
  if (lines.empty()) {
    fmt::print("The requests are the same.\n");
    return;
  }
  report::TextTable table{.columns = {{.head = "request"}, {.head = "first"}, {.head = "second"}}};
  for (std::size_t i = 0; i < std::min(lines.size(), k_lines_shown_max); ++i)
    table.rows.push_back({lines[i].key, lines[i].first.empty() ? "-" : lines[i].first,
                          lines[i].second.empty() ? "-" : lines[i].second});
  fmt::print("{}", to_text(table, terminal::width_of(stdout)));
  if (lines.size() > k_lines_shown_max)
    fmt::print("and {} more keys (--json prints all)\n", lines.size() - k_lines_shown_max);
}

void print_comparison(const browse::Browsed& browsed, const Comparison& comparison) {
  constexpr std::array k_order{"first", "second"};
  for (std::size_t i = 0; i < browsed.archives.size(); ++i) {
    const browse::BrowsedArchive& archive = browsed.archives[i];
    fmt::print("{:7} {}: world {}, {} animations, run {}\n", k_order.at(i), archive.path,
               archive.index.world, comparison.animations[i],
               archive.index.run_id.substr(0, browse::k_run_letters));
  }
  if (const std::size_t twice = browsed.archives[1].twice; twice > 0)
    fmt::print(
        "{} animations are in both archives; the groups and the test below count them only as "
        "animations of the first archive.\n",
        twice);
  fmt::print("\n");
  print_requests(comparison.request);
  report::TextTable table{.columns = {{.head = "number"},
                                      {.head = "mean first", .to_the_right = true},
                                      {.head = "mean second", .to_the_right = true},
                                      {.head = "sd first", .to_the_right = true},
                                      {.head = "sd second", .to_the_right = true},
                                      {.head = "min first", .to_the_right = true, .rank = 1},
                                      {.head = "min second", .to_the_right = true, .rank = 1},
                                      {.head = "max first", .to_the_right = true, .rank = 1},
                                      {.head = "max second", .to_the_right = true, .rank = 1}}};
  for (const analysis::ComparedNumber& number : comparison.numbers) {
    if (number.of[0].count == 0 && number.of[1].count == 0) continue;
    std::vector<std::string> row{number.name};
    for (const auto member : {&analysis::Spread::mean, &analysis::Spread::sd,
                              &analysis::Spread::least, &analysis::Spread::most}) {
      for (const analysis::Spread& spread : number.of)
        row.push_back(spread.count == 0 ? std::string() : browse::shown_number(spread.*member));
    }
    table.rows.push_back(std::move(row));
  }
  fmt::print("\n{}", to_text(table, terminal::width_of(stdout)));
  if (!comparison.why_no_groups.empty()) {
    fmt::print("\nLooks were not compared: {}.\n", comparison.why_no_groups);
    return;
  }
  report::TextTable groups{.columns = {{.head = "like"},
                                       {.head = "in first", .to_the_right = true},
                                       {.head = "in second", .to_the_right = true}}};
  for (const ComparedGroup& group : comparison.groups)
    groups.rows.push_back({group.representative, fmt::format("{}", group.members[0]),
                           fmt::format("{}", group.members[1])});
  fmt::print("\n{}", to_text(groups, terminal::width_of(stdout)));
  fmt::print(
      "\n{} + {} animations were tested, with the {} nearest neighbours of each:\n{:.1f}% of the "
      "neighbours are from the same archive; {:.1f}% are expected by chance (p = {:.3f}).\n",
      comparison.looks.tested[0], comparison.looks.tested[1], browse::k_neighbours,
      100 * comparison.looks.test.share, 100 * comparison.looks.test.expected,
      comparison.looks.test.p_value);
}

}  // namespace

int compare_archives(const CompareOptions& options) {
  return terminal::with_results([&] {
    // Browse the archives separately. If both were browsed together, animations that are in both
    // would be omitted.
    browse::Browsed browsed = browse::browse_archives({options.first});
    browsed.archives.push_back(
        std::move(browse::browse_archives({options.second}).archives.front()));
    Comparison comparison;
    for (std::size_t i = 0; i < 2; ++i)
      comparison.animations[i] = browsed.archives[i].index.entries.size();
    comparison.request =
        analysis::other_lines(request_of(options.first), request_of(options.second));
    comparison.numbers =
        analysis::compared_numbers(browsed.archives[0].index, browsed.archives[1].index);
    leave_out_twice(browsed);
    compare_looks(browsed, options.groups, comparison);
    if (options.json) {
      fmt::print("{}\n", comparison_json(browsed, comparison).dump(2));
    } else {
      print_comparison(browsed, comparison);
    }
    return static_cast<int>(base::ExitCode::ok);
  });
}

}  // namespace sleight::cli
