#include "clients/analysis/comparison.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <sstream>
#include <utility>

#include "clients/browse/groups.h"
#include "clients/browse/resemblance.h"

namespace sleight::analysis {
namespace {

/// Maximum animations of an archive that are compared pair by pair.
constexpr std::size_t k_tested_max = browse::k_full_matrix_max / 2;

Spread spread_of(const browse::Index& index, std::size_t number) {
  Spread spread;
  double squares = 0;
  for (const browse::Entry& entry : index.entries) {
    const double value = entry.numbers[number];
    if (!std::isfinite(value)) continue;
    // Welford's recurrence avoids cancellation.
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

/// Returns the values of a normalised request by key, in the request's order.
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
      // Append the next line of a value that spans several lines.
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

std::vector<ComparedNumber> compared_numbers(const browse::Index& first,
                                             const browse::Index& second) {
  std::vector<ComparedNumber> numbers;
  const auto& of_first = first.numbers;
  const auto& of_second = second.numbers;
  for (std::size_t i = 0; i < of_first.size(); ++i) {
    if (i == browse::k_chain || i == browse::k_draw || i == browse::k_lineage) continue;
    const auto same = std::ranges::find(of_second, of_first[i]);
    if (same == of_second.end()) continue;
    const auto j = static_cast<std::size_t>(same - of_second.begin());
    numbers.push_back(
        {.name = of_first[i].name, .of = {spread_of(first, i), spread_of(second, j)}});
  }
  return numbers;
}

ComparedLooks compared_looks(const std::array<std::vector<const browse::Entry*>, 2>& sets,
                             const scene::Scene& scene, std::size_t threads) {
  ComparedLooks looks;
  std::vector<std::uint8_t> set_of;
  std::vector<const browse::Entry*> tested;
  for (std::uint8_t set = 0; set < 2; ++set) {
    for (const std::size_t i : browse::evenly_chosen(sets[set], k_tested_max)) {
      tested.push_back(sets[set][i]);
      set_of.push_back(set);
      ++looks.tested[set];
    }
  }
  const browse::Sketches sketches(tested, scene);
  looks.test = browse::neighbour_test(sketches.matrix(threads), set_of);
  return looks;
}

}  // namespace sleight::analysis
