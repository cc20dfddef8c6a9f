#include "clients/cli/compare_command.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <sstream>

#include "clients/browse/agreement.h"
#include "clients/browse/groups.h"
#include "clients/browse/resemblance.h"
#include "clients/cli/browsed.h"
#include "clients/cli/browsed_json.h"
#include "clients/cli/dumped_json.h"
#include "clients/cli/groups_command.h"
#include "clients/cli/output.h"
#include "clients/cli/terminal.h"
#include "clients/cli/text_table.h"
#include "common/archive/remote/remote_source.h"
#include "common/archive/summary.h"
#include "common/base/cores.h"
#include "common/base/error.h"
#include "common/json/value.h"

namespace sleight::cli {
namespace {

using Json = json::Value;

/// Of each archive at most so many are compared pair by pair.
constexpr std::size_t k_tested_max = browse::k_full_matrix_max / 2;
constexpr std::size_t k_lines_shown_max = 40;

/// Mean and spread of a number over the animations of an archive that have it.
struct Spread {
  std::size_t count = 0;
  double mean = 0;
  double sd = 0;
  double least = 0;
  double most = 0;
};

Spread spread_of(const BrowsedArchive& archive, std::size_t number) {
  Spread spread;
  double squares = 0;
  for (const browse::Entry& entry : archive.index.entries) {
    const double value = entry.numbers[number];
    if (!std::isfinite(value)) continue;
    // Welford's recurrence, which does not cancel.
    ++spread.count;
    const double off = value - spread.mean;
    spread.mean += off / static_cast<double>(spread.count);
    squares += off * (value - spread.mean);
    spread.least = spread.count == 1 ? value : std::min(spread.least, value);
    spread.most = spread.count == 1 ? value : std::max(spread.most, value);
  }
  if (spread.count > 1) spread.sd = std::sqrt(squares / static_cast<double>(spread.count - 1));
  return spread;
}

struct ComparedNumber {
  std::string name;
  std::array<Spread, 2> of;
};

struct ComparedGroup {
  std::string representative;
  std::array<std::size_t, 2> members{};
};

struct Comparison {
  std::array<std::size_t, 2> animations{};
  std::vector<OtherLine> request;
  std::vector<ComparedNumber> numbers;
  std::string why_no_groups;  ///< empty: there are groups and a test
  std::vector<ComparedGroup> groups;
  std::array<std::size_t, 2> tested{};
  browse::NeighbourTest test{};
};

std::string request_of(const std::string& path) {
  return archive::summary_of(*archive::remote::open_remote(path)).request_text;
}

std::vector<ComparedNumber> compared_numbers(const Browsed& browsed) {
  std::vector<ComparedNumber> numbers;
  const auto& of_first = browsed.archives[0].index.numbers;
  const auto& of_second = browsed.archives[1].index.numbers;
  for (std::size_t i = 0; i < of_first.size(); ++i) {
    if (i == browse::k_chain || i == browse::k_draw || i == browse::k_lineage) continue;
    const auto same = std::ranges::find(of_second, of_first[i]);
    if (same == of_second.end()) continue;
    const auto j = static_cast<std::size_t>(same - of_second.begin());
    numbers.push_back(
        {.name = of_first[i].name,
         .of = {spread_of(browsed.archives[0], i), spread_of(browsed.archives[1], j)}});
  }
  return numbers;
}

void compare_looks(const Browsed& browsed, std::size_t groups, Comparison& comparison) {
  const auto& archives = browsed.archives;
  if (!browse::are_comparable(archives[0].index.scene, archives[1].index.scene)) {
    comparison.why_no_groups = "they have other bodies";
    return;
  }
  std::vector<Picked> all;
  std::vector<std::uint8_t> set_of;
  std::vector<const browse::Entry*> tested;
  for (std::uint8_t set = 0; set < 2; ++set) {
    std::vector<const browse::Entry*> own;
    for (const browse::Entry& entry : archives[set].index.entries) {
      all.push_back({.archive = &archives[set], .entry = &entry});
      own.push_back(&entry);
    }
    for (const std::size_t i : browse::evenly_chosen(own, k_tested_max)) {
      tested.push_back(own[i]);
      set_of.push_back(set);
      ++comparison.tested[set];
    }
  }
  if (comparison.tested[0] == 0 || comparison.tested[1] == 0) {
    comparison.why_no_groups = archives[1].twice > 0 && comparison.tested[1] == 0
                                   ? "all animations of the second are in the first"
                                   : "one of them has no animations";
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
  const browse::Sketches sketches(tested, archives[0].index.scene);
  comparison.test = browse::neighbour_test(sketches.matrix(base::cores_here()), set_of);
}

Json spread_json(const Spread& spread) {
  if (spread.count == 0) return {{"count", 0}};
  return {{"count", spread.count},
          {"mean", spread.mean},
          {"sd", spread.sd},
          {"least", spread.least},
          {"most", spread.most}};
}

Json comparison_json(const Browsed& browsed, const Comparison& comparison) {
  Json json = archives_json(browsed);
  json["request"] = Json::array();
  for (const OtherLine& line : comparison.request) {
    const auto value = [](const std::string& text) { return text.empty() ? Json() : Json(text); };
    json["request"].push_back(
        {{"key", line.key}, {"first", value(line.first)}, {"second", value(line.second)}});
  }
  json["numbers"] = Json::array();
  for (const ComparedNumber& number : comparison.numbers)
    json["numbers"].push_back({{"name", number.name},
                               {"first", spread_json(number.of[0])},
                               {"second", spread_json(number.of[1])}});
  json["groups"] = Json::array();
  for (const ComparedGroup& group : comparison.groups)
    json["groups"].push_back({{"representative", group.representative},
                              {"first", group.members[0]},
                              {"second", group.members[1]}});
  if (comparison.why_no_groups.empty()) {
    json["nearest_neighbours"] = {{"tested_first", comparison.tested[0]},
                                  {"tested_second", comparison.tested[1]},
                                  {"share_same", comparison.test.share},
                                  {"expected", comparison.test.expected},
                                  {"p_value", comparison.test.p_value}};
  } else {
    json["not_compared"] = comparison.why_no_groups;
  }
  return json;
}

void print_requests(const std::vector<OtherLine>& lines) {
  if (lines.empty()) {
    fmt::print("The requests are the same.\n");
    return;
  }
  TextTable table{.columns = {{.head = "request"}, {.head = "first"}, {.head = "second"}}};
  for (std::size_t i = 0; i < std::min(lines.size(), k_lines_shown_max); ++i)
    table.rows.push_back({lines[i].key, lines[i].first.empty() ? "-" : lines[i].first,
                          lines[i].second.empty() ? "-" : lines[i].second});
  fmt::print("{}", to_text(table, width_of(stdout)));
  if (lines.size() > k_lines_shown_max)
    fmt::print("and {} keys more (--json has all)\n", lines.size() - k_lines_shown_max);
}

void print_comparison(const Browsed& browsed, const Comparison& comparison) {
  constexpr std::array k_order{"first", "second"};
  for (std::size_t i = 0; i < browsed.archives.size(); ++i) {
    const BrowsedArchive& archive = browsed.archives[i];
    fmt::print("{:7} {}: {} of {} animations, run {}\n", k_order.at(i), archive.path,
               archive.index.world, comparison.animations[i],
               archive.index.run_id.substr(0, browse::k_run_letters));
  }
  if (const std::size_t twice = browsed.archives[1].twice; twice > 0)
    fmt::print("{} animations are in both; in the looks below they are the first's alone.\n",
               twice);
  fmt::print("\n");
  print_requests(comparison.request);
  TextTable table{.columns = {{.head = "number"},
                              {.head = "mean first", .to_the_right = true},
                              {.head = "mean second", .to_the_right = true},
                              {.head = "sd first", .to_the_right = true},
                              {.head = "sd second", .to_the_right = true},
                              {.head = "least first", .to_the_right = true, .rank = 1},
                              {.head = "least second", .to_the_right = true, .rank = 1},
                              {.head = "most first", .to_the_right = true, .rank = 1},
                              {.head = "most second", .to_the_right = true, .rank = 1}}};
  for (const ComparedNumber& number : comparison.numbers) {
    if (number.of[0].count == 0 && number.of[1].count == 0) continue;
    std::vector<std::string> row{number.name};
    for (const auto member : {&Spread::mean, &Spread::sd, &Spread::least, &Spread::most}) {
      for (const Spread& spread : number.of)
        row.push_back(spread.count == 0 ? std::string() : shown_number(spread.*member));
    }
    table.rows.push_back(std::move(row));
  }
  fmt::print("\n{}", to_text(table, width_of(stdout)));
  if (!comparison.why_no_groups.empty()) {
    fmt::print("\nTheir looks are not compared: {}.\n", comparison.why_no_groups);
    return;
  }
  TextTable groups{.columns = {{.head = "like"},
                               {.head = "of first", .to_the_right = true},
                               {.head = "of second", .to_the_right = true}}};
  for (const ComparedGroup& group : comparison.groups)
    groups.rows.push_back({group.representative, fmt::format("{}", group.members[0]),
                           fmt::format("{}", group.members[1])});
  fmt::print("\n{}", to_text(groups, width_of(stdout)));
  fmt::print(
      "\nOf the {} nearest neighbours of each of {} + {} animations {:.1f}% are of the same "
      "archive;\n"
      "if the two were dealt at random, {:.1f}%: p = {:.3f}.\n",
      browse::k_neighbours, comparison.tested[0], comparison.tested[1], 100 * comparison.test.share,
      100 * comparison.test.expected, comparison.test.p_value);
}

/// The values of a normalised request by key, in its order.
std::vector<std::pair<std::string, std::string>> lines_of(const std::string& text) {
  std::vector<std::pair<std::string, std::string>> lines;
  std::map<std::string, int> tables;
  std::string section;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) {
    if (line.empty() || line.front() == '#') continue;
    if (line.starts_with("[[")) {
      const std::string name = line.substr(2, line.find(']') - 2);
      section = fmt::format("{}[{}].", name, ++tables[name]);
    } else if (line.front() == '[') {
      section = line.substr(1, line.find(']') - 1) + ".";
    } else if (const std::size_t equals = line.find(" = "); equals != std::string::npos) {
      lines.emplace_back(section + line.substr(0, equals), line.substr(equals + 3));
    } else if (!lines.empty()) {
      // A value of several lines.
      lines.back().second += " " + line;
    }
  }
  return lines;
}

}  // namespace

std::vector<OtherLine> other_lines(const std::string& first, const std::string& second) {
  const auto of_first = lines_of(first);
  const auto of_second = lines_of(second);
  const std::map<std::string, std::string> values(of_second.begin(), of_second.end());
  std::map<std::string, bool> is_seen;
  std::vector<OtherLine> other;
  for (const auto& [key, value] : of_first) {
    is_seen[key] = true;
    const auto found = values.find(key);
    if (found == values.end()) {
      other.push_back({.key = key, .first = value});
    } else if (found->second != value) {
      other.push_back({.key = key, .first = value, .second = found->second});
    }
  }
  for (const auto& [key, value] : of_second) {
    if (!is_seen[key]) other.push_back({.key = key, .second = value});
  }
  return other;
}

int compare_archives(const CompareOptions& options) {
  return with_results([&] {
    // Each by itself: numbers are of all that an archive has, also of what is in both.
    Browsed browsed = browse_archives({options.first});
    browsed.archives.push_back(std::move(browse_archives({options.second}).archives.front()));
    Comparison comparison;
    for (std::size_t i = 0; i < 2; ++i)
      comparison.animations[i] = browsed.archives[i].index.entries.size();
    comparison.request = other_lines(request_of(options.first), request_of(options.second));
    comparison.numbers = compared_numbers(browsed);
    leave_out_twice(browsed);
    compare_looks(browsed, options.groups, comparison);
    if (options.json) {
      fmt::print("{}\n", dumped(comparison_json(browsed, comparison)));
    } else {
      print_comparison(browsed, comparison);
    }
    return static_cast<int>(base::ExitCode::ok);
  });
}

}  // namespace sleight::cli
