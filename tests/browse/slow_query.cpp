#include "tests/browse/slow_query.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "tests/support/numbers.h"

namespace sleight::browse::testing {
namespace {

/// Rounding error of a position whose coordinates are at most a few metres.
constexpr double k_rounding_m = 1e-9;

math::Vec3 place_of(const Piece& piece, double t_s) {
  const double s = t_s - piece.start_s;
  return piece.position_m + s * piece.velocity_mps + 0.5 * s * s * piece.acceleration_mps2;
}

bool is_in(const math::Vec3& place_m, const Box& box, double margin_m) {
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    if (place_m[axis] < box.low_m[axis] - margin_m || place_m[axis] > box.high_m[axis] + margin_m)
      return false;
  }
  return true;
}

/// Appends the times at which a coordinate equals `bound`.
void add_roots(double p, double v, double a, double bound, double start_s,
               std::vector<double>& moments) {
  if (!std::isfinite(bound)) return;
  const double c = p - bound;
  if (a == 0) {
    if (v != 0) moments.push_back(start_s - c / v);
    return;
  }
  const double square = v * v - 2 * a * c;
  if (square < 0) return;
  for (const double sign : {-1.0, 1.0}) {
    moments.push_back(start_s + (-v + sign * std::sqrt(square)) / a);
    // Append the same root by another formula, because its rounding differs.
    const double q = -(v + sign * std::sqrt(square));
    if (q != 0) moments.push_back(start_s + 2 * c / q);
  }
}

std::vector<double> moments_of(const Piece& piece, double from_s, double to_s, const Box& box,
                               double margin_m) {
  std::vector<double> moments{from_s};
  if (std::isfinite(to_s)) moments.push_back(to_s);
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    for (const double bound : {box.low_m[axis] - margin_m, box.high_m[axis] + margin_m})
      add_roots(piece.position_m[axis], piece.velocity_mps[axis], piece.acceleration_mps2[axis],
                bound, piece.start_s, moments);
  }
  std::erase_if(moments, [&](double t_s) { return !(t_s >= from_s && t_s <= to_s); });
  std::ranges::sort(moments);
  return moments;
}

/// Returns when the condition is first met. For `every`, this is the latest of the bodies' first
/// times; for `any`, the earliest.
template <class FirstOf>
std::optional<double> slow_first_of(const Bodies& who, const Entry& entry, FirstOf first_of_body) {
  std::vector<double> firsts;
  std::size_t entering = 0;
  for (const std::uint32_t body : who.bodies) {
    if (entry.tracks[body].count == 0) continue;
    ++entering;
    if (const auto first = first_of_body(body)) firsts.push_back(*first);
  }
  if (firsts.empty() || (who.is_every && firsts.size() < entering)) return std::nullopt;
  return who.is_every ? std::ranges::max(firsts) : std::ranges::min(firsts);
}

struct Slow {
  const Entry& entry;
  double margin_m;

  std::optional<double> first(const Condition& condition, double after_s, double hit_s) const {
    if (const auto* inside = std::get_if<Inside>(&condition.is)) {
      return slow_first_of(inside->who, entry, [&](std::uint32_t body) {
        return slow_first_inside(
            entry.pieces_of(body), inside->box,
            {.from_s = std::max(after_s, inside->when.from_s), .to_s = inside->when.to_s},
            margin_m);
      });
    }
    const auto& touches = std::get<Touches>(condition.is);
    const auto among = [&](std::uint32_t feature) {
      return touches.partners.empty() ||
             std::ranges::find(touches.partners, feature) != touches.partners.end();
    };
    return slow_first_of(touches.who, entry, [&](std::uint32_t body) -> std::optional<double> {
      std::optional<double> found;
      for (const Contact& hit : entry.contacts) {
        if (hit.time_s < touches.when.from_s || hit.time_s > touches.when.to_s ||
            hit.time_s < after_s || hit.time_s <= hit_s)
          continue;
        if ((hit.body == body && among(hit.partner)) || (hit.partner == body && among(hit.body)))
          found = std::min(found.value_or(k_infinity), hit.time_s);
      }
      return found;
    });
  }

  bool operator()(const Inside& inside) const {
    return first({inside}, -k_infinity, -k_infinity).has_value();
  }
  bool operator()(const Touches& touches) const {
    return first({touches}, -k_infinity, -k_infinity).has_value();
  }
  bool operator()(const EndsIn& ends) const {
    return slow_first_of(ends.who, entry,
                         [&](std::uint32_t body) -> std::optional<double> {
                           const Piece& last = entry.pieces_of(body).back();
                           if (!is_in(last.position_m, ends.box, margin_m)) return std::nullopt;
                           return 0;
                         })
        .has_value();
  }
  bool operator()(const NumberIn& in) const {
    const double number = entry.numbers[in.number];
    if (std::isnan(number) || number < in.low || number > in.high) return false;
    return !(in.is_low_open && number == in.low) && !(in.is_high_open && number == in.high);
  }
  bool operator()(const InOrder& order) const {
    double after_s = -k_infinity;
    double hit_s = -k_infinity;
    for (const Condition& step : order.steps) {
      const auto met = first(step, after_s, hit_s);
      if (!met) return false;
      after_s = *met;
      if (std::holds_alternative<Touches>(step.is)) hit_s = *met;
    }
    return true;
  }
  bool operator()(const AllOf& all) const {
    bool is_each = true;
    for (const Condition& part : all.parts)
      is_each = std::visit(*this, part.is) && is_each;
    return is_each;
  }
  bool operator()(const AnyOf& any) const {
    bool is_one = false;
    for (const Condition& part : any.parts)
      is_one = std::visit(*this, part.is) || is_one;
    return is_one;
  }
  bool operator()(const Not& no) const { return !std::visit(*this, no.part.front().is); }
};

std::size_t below(random::Stream& stream, std::size_t bound) {
  return std::min(bound - 1,
                  static_cast<std::size_t>(stream.uniform() * static_cast<double>(bound)));
}

const Entry& some_entry(const Index& index, random::Stream& stream) {
  return index.entries[below(stream, index.entries.size())];
}

/// Returns a box around a random position of a body in a random animation. Some sides are open.
Box some_box(const Index& index, random::Stream& stream, bool at_rest) {
  const Entry& entry = some_entry(index, stream);
  math::Vec3 middle_m{0, 0, 0};
  if (!entry.pieces.empty()) {
    const Piece& piece = entry.pieces[below(stream, entry.pieces.size())];
    middle_m =
        at_rest ? piece.position_m : place_of(piece, piece.start_s + 0.02 * stream.uniform());
  }
  const math::Vec3 size_m = index.scene.high_m - index.scene.low_m;
  Box box;
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    const double side_m = std::max(1e-3, size_m[axis]) * std::pow(10, -2.5 * stream.uniform());
    const double shift_m = side_m * (stream.uniform() - 0.5);
    if (stream.uniform() < 0.85) box.low_m[axis] = middle_m[axis] + shift_m - 0.6 * side_m;
    if (stream.uniform() < 0.85) box.high_m[axis] = middle_m[axis] + shift_m + 0.6 * side_m;
  }
  return box;
}

Stretch some_stretch(const Index& index, random::Stream& stream) {
  if (stream.uniform() < 0.3) return {};
  const double end_s = std::max(0.1, some_entry(index, stream).end_s);
  const double from_s = 1.2 * end_s * stream.uniform() - 0.05 * end_s;
  const double length_s = end_s * std::pow(10, -3 * stream.uniform());
  Stretch when{.from_s = from_s, .to_s = from_s + length_s};
  if (stream.uniform() < 0.2) when.from_s = -k_infinity;
  if (stream.uniform() < 0.2) when.to_s = k_infinity;
  return when;
}

Bodies some_bodies(const Index& index, random::Stream& stream) {
  const std::uint32_t bodies = index.scene.bodies();
  Bodies who;
  const double kind = stream.uniform();
  if (kind < 0.5) {
    who.bodies = {static_cast<std::uint32_t>(below(stream, bodies))};
    return who;
  }
  for (std::uint32_t body = 0; body < bodies; ++body)
    who.bodies.push_back(body);
  who.is_every = kind < 0.6;
  return who;
}

Condition some_moment(const Index& index, random::Stream& stream) {
  if (stream.uniform() < 0.6)
    return {Inside{.who = some_bodies(index, stream),
                   .box = some_box(index, stream, false),
                   .when = some_stretch(index, stream)}};
  Touches touches{.who = some_bodies(index, stream), .when = some_stretch(index, stream)};
  if (stream.uniform() < 0.7)
    touches.partners = {static_cast<std::uint32_t>(below(stream, index.scene.features.size()))};
  return {std::move(touches)};
}

Condition some_term(const Index& index, random::Stream& stream) {
  const double kind = stream.uniform();
  if (kind < 0.6) return some_moment(index, stream);
  if (kind < 0.7)
    return {EndsIn{.who = some_bodies(index, stream), .box = some_box(index, stream, true)}};
  if (kind < 0.85) {
    InOrder order;
    const std::size_t steps = 2 + below(stream, 2);
    for (std::size_t i = 0; i < steps; ++i)
      order.steps.push_back(some_moment(index, stream));
    return {std::move(order)};
  }
  NumberIn in{.number = below(stream, index.numbers.size())};
  const double a = some_entry(index, stream).numbers[in.number];
  const double b = some_entry(index, stream).numbers[in.number];
  if (std::isfinite(a) && stream.uniform() < 0.8) in.low = a;
  if (std::isfinite(b) && stream.uniform() < 0.8) in.high = b;
  if (in.low > in.high) std::swap(in.low, in.high);
  in.is_low_open = stream.uniform() < 0.3;
  in.is_high_open = stream.uniform() < 0.3;
  return {in};
}

}  // namespace

std::optional<double> slow_first_inside(std::span<const Piece> pieces, const Box& box,
                                        const Stretch& when, double margin_m) {
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    const Piece& piece = pieces[i];
    const double end_s = i + 1 < pieces.size() ? pieces[i + 1].start_s : k_infinity;
    const double from_s = std::max(piece.start_s, when.from_s);
    const double to_s = std::min(end_s, when.to_s);
    if (from_s > to_s) continue;
    const std::vector<double> moments = moments_of(piece, from_s, to_s, box, margin_m);
    for (std::size_t m = 0; m < moments.size(); ++m) {
      if (is_in(place_of(piece, moments[m]), box, margin_m)) return moments[m];
      const bool is_last = m + 1 == moments.size();
      // After the last root of an endless piece, the body crosses no bound.
      if (is_last && std::isfinite(to_s)) continue;
      const double middle_s = is_last ? moments[m] + 1 : 0.5 * (moments[m] + moments[m + 1]);
      if (is_in(place_of(piece, middle_s), box, margin_m)) return moments[m];
    }
  }
  return std::nullopt;
}

bool slow_is_met(const Condition& condition, const Entry& entry, double margin_m) {
  return std::visit(Slow{.entry = entry, .margin_m = margin_m}, condition.is);
}

bool is_close_call(const Condition& condition, const Entry& entry) {
  return slow_is_met(condition, entry, k_rounding_m) !=
             slow_is_met(condition, entry, -k_rounding_m) ||
         slow_is_met(condition, entry, k_rounding_m) != slow_is_met(condition, entry, 0);
}

Condition random_condition(const Index& index, random::Stream& stream, int depth) {
  const double kind = stream.uniform();
  if (depth <= 1 || kind < 0.4) return some_term(index, stream);
  if (kind < 0.55) {
    Not no;
    no.part.push_back(random_condition(index, stream, depth - 1));
    return {std::move(no)};
  }
  std::vector<Condition> parts;
  const std::size_t count = 2 + below(stream, 2);
  for (std::size_t i = 0; i < count; ++i)
    parts.push_back(random_condition(index, stream, depth - 1));
  if (kind < 0.78) return {AllOf{.parts = std::move(parts)}};
  return {AnyOf{.parts = std::move(parts)}};
}

}  // namespace sleight::browse::testing
