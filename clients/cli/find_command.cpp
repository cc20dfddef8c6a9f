#include "clients/cli/find_command.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <utility>

#include "clients/cli/browsed_json.h"
#include "clients/report/text_table.h"
#include "clients/terminal/output.h"
#include "clients/terminal/terminal.h"
#include "common/base/error.h"
#include "common/json/value.h"
#include "common/request/nearest.h"

namespace sleight::cli {
namespace {

std::size_t number_called(const std::string& name, const browse::BrowsedArchive& archive) {
  const auto& numbers = archive.index.numbers;
  const auto found = std::ranges::find(numbers, name, &browse::NumberName::name);
  if (found != numbers.end()) return static_cast<std::size_t>(found - numbers.begin());
  std::vector<std::string> known;
  for (const browse::NumberName& number : numbers)
    known.push_back(number.name);
  const auto near = request::nearest(name, known);
  throw base::Error(base::ExitCode::usage,
                    fmt::format("--sort: {} has no number '{}'{}", archive.path, name,
                                near ? fmt::format("; did you mean '{}'?", *near)
                                     : "; to list the numbers, run `sleight find --names`"));
}

void sort_picked(const std::string& name, bool descending, std::vector<browse::Picked>& picked) {
  std::vector<std::pair<double, browse::Picked>> keyed;
  for (const browse::Picked& one : picked)
    keyed.emplace_back(one.entry->numbers[number_called(name, *one.archive)], one);
  // If animations are sorted by a number, animations without the number come last, even in
  // descending order.
  std::ranges::stable_sort(keyed, [&](const auto& a, const auto& b) {
    if (std::isnan(a.first) || std::isnan(b.first)) return !std::isnan(a.first);
    return descending ? a.first > b.first : a.first < b.first;
  });
  std::ranges::transform(keyed, picked.begin(), &std::pair<double, browse::Picked>::second);
}

/// Whether `name` occurs as a whole word. For example, "end" doesn't occur in "ends in".
bool is_spoken_of(const std::string& name, const std::string& words) {
  const auto is_of_word = [](char c) {
    return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_';
  };
  for (std::size_t at = words.find(name); at != std::string::npos; at = words.find(name, at + 1)) {
    const std::size_t end = at + name.size();
    if ((at == 0 || !is_of_word(words[at - 1])) && (end == words.size() || !is_of_word(words[end])))
      return true;
  }
  return false;
}

/// Returns the names of numbers in the queries and in --sort.
std::vector<std::string> asked_numbers(const FindOptions& options, const browse::Browsed& browsed) {
  std::string words = options.sort + " ";
  for (const auto* list : {&options.asked.where, &options.asked.in, &options.asked.not_in}) {
    for (const std::string& text : *list)
      words += text + " ";
  }
  std::vector<std::string> names;
  for (std::size_t i = browse::k_log_constraint; i < browsed.archives.front().index.numbers.size();
       ++i) {
    const std::string& name = browsed.archives.front().index.numbers[i].name;
    const bool is_shown_anyway = i == browse::k_rest_s || i == browse::k_events ||
                                 i == browse::k_chain || i == browse::k_draw;
    if (!is_shown_anyway && is_spoken_of(name, words)) names.push_back(name);
  }
  return names;
}

void print_table(const FindOptions& options, const browse::Browsed& browsed,
                 const std::vector<browse::Picked>& shown) {
  report::TextTable table{.columns = {{.head = "animation"},
                                      {.head = "log_prior", .to_the_right = true},
                                      {.head = "rest_s", .to_the_right = true},
                                      {.head = "events", .to_the_right = true}}};
  const std::vector<std::string> names = asked_numbers(options, browsed);
  for (const std::string& name : names)
    table.columns.push_back({.head = name, .to_the_right = true, .rank = 1});
  table.columns.push_back({.head = "in proportion", .rank = 2});
  const bool has_archives = browsed.archives.size() > 1;
  if (has_archives) table.columns.push_back({.head = "archive", .rank = 3});
  for (const browse::Picked& one : shown) {
    const browse::Entry& entry = *one.entry;
    std::vector<std::string> row{
        name_among(browsed, entry.name), browse::shown_number(entry.numbers[browse::k_log_prior]),
        fmt::format("{:.3f}", entry.end_s), fmt::format("{}", entry.events)};
    for (const std::string& name : names) {
      const auto& numbers = one.archive->index.numbers;
      const auto found = std::ranges::find(numbers, name, &browse::NumberName::name);
      row.push_back(found == numbers.end()
                        ? std::string()
                        : browse::shown_number(
                              entry.numbers[static_cast<std::size_t>(found - numbers.begin())]));
    }
    row.emplace_back(entry.in_proportion ? "yes" : "no");
    if (has_archives) row.push_back(one.archive->path);
    table.rows.push_back(std::move(row));
  }
  fmt::print("{}", to_text(table, terminal::width_of(stdout)));
}

int print_names(const FindOptions& options, const browse::Browsed& browsed) {
  json::Value json = json::Value::array();
  for (const browse::BrowsedArchive& archive : browsed.archives) {
    if (options.json) {
      json.push_back(names_json(archive));
      continue;
    }
    fmt::print("{}\n", archive.path);
    const scene::Scene& scene = archive.index.scene;
    const auto print_features = [&](const char* head, scene::FeatureKind kind) {
      for (const scene::Feature& feature : scene.features) {
        if (feature.kind == kind) fmt::print("  {:9}{}\n", std::exchange(head, ""), feature.name);
      }
    };
    print_features("bodies", scene::FeatureKind::body);
    print_features("things", scene::FeatureKind::fixed);
    const char* head = "numbers";
    for (const browse::NumberName& number : archive.index.numbers) {
      fmt::print("  {:9}{}{}\n", std::exchange(head, ""), number.name,
                 number.unit == "1" ? "" : fmt::format("  [{}]", number.unit));
    }
  }
  if (options.json) fmt::print("{}\n", json.dump(2));
  return static_cast<int>(base::ExitCode::ok);
}

}  // namespace

int find_animations(const FindOptions& options) {
  if (options.descending && options.sort.empty())
    throw base::Error(base::ExitCode::usage, "--descending requires --sort NUMBER");
  if (options.ids && options.json)
    throw base::Error(base::ExitCode::usage, "--ids and --json can't be combined");
  return terminal::with_results([&] {
    browse::Browsed browsed = browse::browse_archives(options.paths);
    std::vector<browse::Picked> found =
        options.names ? std::vector<browse::Picked>() : picked(browsed, options.asked);
    say_what_is_missing(browsed);
    if (options.names) return print_names(options, browsed);
    const std::size_t total = found.size();
    if (!options.sort.empty()) sort_picked(options.sort, options.descending, found);
    if (options.limit > 0 && found.size() > options.limit) found.resize(options.limit);
    if (options.json) {
      json::Value json = archives_json(browsed);
      json["found"] = total;
      json["of"] = browsed.animations();
      json["animations"] = json::Value::array();
      for (const browse::Picked& one : found)
        json["animations"].push_back(animation_json(browsed, one));
      fmt::print("{}\n", json.dump(2));
      return static_cast<int>(base::ExitCode::ok);
    }
    if (options.ids) {
      for (const browse::Picked& one : found)
        fmt::print("{}\n", name_among(browsed, one.entry->name));
      return static_cast<int>(base::ExitCode::ok);
    }
    if (!found.empty()) print_table(options, browsed, found);
    fmt::print(
        "{} of {} animations{} match{}\n", total, browsed.animations(),
        browsed.archives.size() > 1 ? fmt::format(" in {} archives", browsed.archives.size()) : "",
        found.size() < total ? fmt::format("; {} shown", found.size()) : "");
    return static_cast<int>(base::ExitCode::ok);
  });
}

}  // namespace sleight::cli
