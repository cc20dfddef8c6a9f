#include "clients/browse/query.h"

#include <algorithm>

namespace sleight::browse {
namespace {

/// The end of the previous step. The next step can hold only from this time on. A hit counts for
/// one step only, so the next step's hit must be later than the last hit.
struct After {
  double time_s = -std::numeric_limits<double>::infinity();
  double hit_s = -std::numeric_limits<double>::infinity();
};

bool overlaps(const Box& a, const Box& b) {
  return (a.low_m.array() <= b.high_m.array()).all() && (b.low_m.array() <= a.high_m.array()).all();
}

/// Returns the minimum of the bodies' earliest times; for `every`, the maximum of these times.
template <class FirstOf>
std::optional<double> first_of(const Bodies& who, const Entry& entry, FirstOf first_of_body) {
  std::optional<double> found;
  for (const std::uint32_t body : who.bodies) {
    if (entry.tracks[body].count == 0) continue;
    const std::optional<double> first = first_of_body(body);
    if (who.is_every) {
      if (!first) return std::nullopt;
      found = found ? std::max(*found, *first) : *first;
    } else if (first) {
      found = found ? std::min(*found, *first) : *first;
    }
  }
  return found;
}

std::optional<double> first_met(const Inside& inside, const Entry& entry, const After& after) {
  const Stretch when{.from_s = std::max(inside.when.from_s, after.time_s),
                     .to_s = inside.when.to_s};
  return first_of(inside.who, entry, [&](std::uint32_t body) -> std::optional<double> {
    if (!overlaps(entry.tracks[body].reach, inside.box)) return std::nullopt;
    return first_inside(entry.pieces_of(body), inside.box, when);
  });
}

bool is_among(std::uint32_t feature, const std::vector<std::uint32_t>& features) {
  return features.empty() || std::ranges::binary_search(features, feature);
}

std::optional<double> first_met(const Touches& touches, const Entry& entry, const After& after) {
  const double from_s = std::max(touches.when.from_s, after.time_s);
  const auto begin = std::ranges::lower_bound(entry.contacts, from_s, {}, &Contact::time_s);
  return first_of(touches.who, entry, [&](std::uint32_t body) -> std::optional<double> {
    for (auto it = begin; it != entry.contacts.end() && it->time_s <= touches.when.to_s; ++it) {
      if (it->time_s <= after.hit_s) continue;
      // A hit of two bodies counts for both, even though only one of them records it.
      const bool is_hit = (it->body == body && is_among(it->partner, touches.partners)) ||
                          (it->partner == body && is_among(it->body, touches.partners));
      if (is_hit) return it->time_s;
    }
    return std::nullopt;
  });
}

bool holds(const Inside& inside, const Entry& entry) {
  return first_met(inside, entry, After{}).has_value();
}

bool holds(const Touches& touches, const Entry& entry) {
  return first_met(touches, entry, After{}).has_value();
}

bool holds(const EndsIn& ends, const Entry& entry) {
  // The last piece begins where the body rests.
  return first_of(ends.who, entry,
                  [&](std::uint32_t body) -> std::optional<double> {
                    const Piece& last = entry.pieces_of(body).back();
                    const bool is_in = (last.position_m.array() >= ends.box.low_m.array()).all() &&
                                       (last.position_m.array() <= ends.box.high_m.array()).all();
                    return is_in ? std::optional(last.start_s) : std::nullopt;
                  })
      .has_value();
}

bool holds(const NumberIn& range, const Entry& entry) {
  const double number = entry.numbers[range.number];
  // Comparisons with NaN are false, so a number that doesn't apply is in no range.
  const bool is_above = range.is_low_open ? number > range.low : number >= range.low;
  const bool is_below = range.is_high_open ? number < range.high : number <= range.high;
  return is_above && is_below;
}

/// Takes each step's earliest moment after the previous step. Choosing later moments for earlier
/// steps never helps.
bool holds(const InOrder& order, const Entry& entry) {
  After after;
  for (const Condition& step : order.steps) {
    const auto* touches = std::get_if<Touches>(&step.is);
    const auto met = touches != nullptr ? first_met(*touches, entry, after)
                                        : first_met(std::get<Inside>(step.is), entry, after);
    if (!met) return false;
    after.time_s = *met;
    if (touches != nullptr) after.hit_s = *met;
  }
  return true;
}

bool holds(const AllOf& all, const Entry& entry) {
  return std::ranges::all_of(all.parts, [&](const Condition& c) { return is_met(c, entry); });
}

bool holds(const AnyOf& any, const Entry& entry) {
  return std::ranges::any_of(any.parts, [&](const Condition& c) { return is_met(c, entry); });
}

bool holds(const Not& no, const Entry& entry) {
  return !is_met(no.part.front(), entry);
}

}  // namespace

bool is_met(const Condition& condition, const Entry& entry) {
  return std::visit([&](const auto& is) { return holds(is, entry); }, condition.is);
}

std::vector<std::size_t> find(const Condition& condition, const Index& index) {
  std::vector<std::size_t> found;
  for (std::size_t i = 0; i < index.entries.size(); ++i) {
    if (is_met(condition, index.entries[i])) found.push_back(i);
  }
  return found;
}

}  // namespace sleight::browse
