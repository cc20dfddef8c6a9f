#include "common/request/nearest.h"

#include <algorithm>
#include <array>
#include <vector>

namespace sleight::request {
namespace {

std::string folded(std::string_view name) {
  std::string same(name);
  for (char& c : same) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
    if (c == '-') c = '_';
  }
  return same;
}

std::size_t edits_max(std::string_view name) {
  return 1 + name.size() / 4;
}

bool is_front_of(std::string_view front, std::string_view whole) {
  constexpr std::size_t k_front_min = 3;  // shorter starts match too many names
  return front.size() >= k_front_min && whole.size() > front.size() && whole.starts_with(front) &&
         whole[front.size()] == '_';
}

}  // namespace

std::size_t edit_distance(std::string_view a, std::string_view b) {
  // row[i] holds the distances from the first i characters of `a` to every prefix of `b`. The
  // algorithm uses only the last three rows.
  std::array<std::vector<std::size_t>, 3> row;
  for (auto& r : row)
    r.resize(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j)
    row[0][j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    auto& now = row[i % 3];
    const auto& before = row[(i - 1) % 3];
    now[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t replaced = before[j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1);
      now[j] = std::min({before[j] + 1, now[j - 1] + 1, replaced});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1]) {
        now[j] = std::min(now[j], row[(i - 2) % 3][j - 2] + 1);
      }
    }
  }
  return row[a.size() % 3][b.size()];
}

std::optional<std::string> nearest(std::string_view written, std::span<const std::string> known) {
  constexpr std::size_t k_length_max = 64;  // no known name is near a longer one
  if (written.size() > k_length_max) return std::nullopt;
  const std::string wanted = folded(written);

  std::optional<std::string> best;
  std::size_t least = 0;
  for (const std::string& name : known) {
    const std::size_t edits = edit_distance(wanted, folded(name));
    // Ignore names that differ in every character: a typing error changes only a few characters.
    if (edits > edits_max(name) || edits >= std::min(wanted.size(), name.size())) continue;
    if (!best || edits < least) best = name, least = edits;
  }
  if (best) return best;

  for (const std::string& name : known) {
    if (is_front_of(wanted, name) || is_front_of(name, wanted)) return name;
  }
  return std::nullopt;
}

}  // namespace sleight::request
