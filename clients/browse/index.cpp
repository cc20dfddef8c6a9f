#include "clients/browse/index.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <iterator>
#include <tuple>

#include <fmt/format.h>

namespace sleight::browse {
namespace {

/// Rounding margin for the box of a piece, relative to the size of its numbers.
constexpr double k_rounding = 1e-12;

std::optional<std::uint64_t> whole_number(std::string_view text) {
  std::uint64_t number = 0;
  const auto [end, failure] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (failure != std::errc{} || end != text.data() + text.size() || text.empty())
    return std::nullopt;
  return number;
}

void widen(Box& box, double low, double high, Eigen::Index axis) {
  const double margin = k_rounding * std::max({1.0, std::abs(low), std::abs(high)});
  box.low_m[axis] = std::min(box.low_m[axis], low - margin);
  box.high_m[axis] = std::max(box.high_m[axis], high + margin);
}

/// Widens the box along one axis to contain a piece of path that ends after `duration_s`.
void widen(Box& box, const Piece& piece, double duration_s, Eigen::Index axis) {
  const double p = piece.position_m[axis];
  const double v = piece.velocity_mps[axis];
  const double a = piece.acceleration_mps2[axis];
  widen(box, p, p, axis);
  if (v == 0 && a == 0) return;
  // The last piece has no end, so its reach is unbounded if it moves.
  const auto at = [&](double s) { return p + s * (v + 0.5 * a * s); };
  const double end = std::isfinite(duration_s) ? at(duration_s)
                     : a != 0                  ? std::copysign(duration_s, a)
                                               : std::copysign(duration_s, v);
  widen(box, std::min(p, end), std::max(p, end), axis);
  const double turn_s = a == 0 ? 0 : -v / a;
  if (turn_s > 0 && turn_s < duration_s) widen(box, at(turn_s), at(turn_s), axis);
}

}  // namespace

const std::vector<NumberName>& own_numbers() {
  static const std::vector<NumberName> names{
      {"log_prior", "1"}, {"log_constraint", "1"}, {"chain", "1"},  {"draw", "1"},
      {"lineage", "1"},   {"rest_s", "s"},         {"events", "1"}, {"in_proportion", "1"}};
  return names;
}

std::string short_text(const AnimationName& name) {
  return name.is_find ? fmt::format("find.{}", name.draw)
                      : fmt::format("c{}.{}", name.chain, name.draw);
}

std::string long_text(const AnimationName& name) {
  return fmt::format("{}:{}", name.run.substr(0, k_run_letters), short_text(name));
}

std::optional<AskedName> parse_name(std::string_view text) {
  AskedName asked;
  if (const std::size_t colon = text.rfind(':'); colon != std::string_view::npos) {
    asked.run = text.substr(0, colon);
    if (asked.run.empty() || asked.run.find(':') != std::string::npos) return std::nullopt;
    text.remove_prefix(colon + 1);
  }
  const std::size_t dot = text.find('.');
  if (dot == std::string_view::npos) return std::nullopt;
  std::string_view first = text.substr(0, dot);
  asked.is_find = first == "find";
  asked.is_bare = !asked.is_find && !first.starts_with('c');
  if (!asked.is_find && !asked.is_bare) first.remove_prefix(1);
  const auto draw = whole_number(text.substr(dot + 1));
  const auto chain = asked.is_find ? std::uint64_t{0} : whole_number(first);
  if (!draw || !chain) return std::nullopt;
  asked.chain = *chain;
  asked.draw = *draw;
  return asked;
}

bool operator==(const Entry& a, const Entry& b) {
  // Treat NaN as equal to itself.
  const auto is_same = [](double x, double y) {
    return x == y || (std::isnan(x) && std::isnan(y));
  };
  return std::tie(a.name, a.row, a.lineage, a.in_proportion, a.end_s, a.events, a.tracks, a.pieces,
                  a.contacts) == std::tie(b.name, b.row, b.lineage, b.in_proportion, b.end_s,
                                          b.events, b.tracks, b.pieces, b.contacts) &&
         std::ranges::equal(a.numbers, b.numbers, is_same);
}

const Piece* piece_at(std::span<const Piece> pieces, double t_s) {
  const auto after = std::ranges::upper_bound(pieces, t_s, {}, &Piece::start_s);
  return after == pieces.begin() ? nullptr : &*std::prev(after);
}

std::optional<math::Vec3> centre_at(std::span<const Piece> pieces, double t_s) {
  const Piece* piece = piece_at(pieces, t_s);
  if (piece == nullptr) return std::nullopt;
  const double s = t_s - piece->start_s;
  return math::Vec3(piece->position_m +
                    s * (piece->velocity_mps + 0.5 * s * piece->acceleration_mps2));
}

void measure_reach(Entry& entry) {
  constexpr double k_infinity = std::numeric_limits<double>::infinity();
  for (std::uint32_t body = 0; body < entry.tracks.size(); ++body) {
    const auto pieces = entry.pieces_of(body);
    // Start with an empty box.
    Box reach{.low_m = math::Vec3::Constant(k_infinity),
              .high_m = math::Vec3::Constant(-k_infinity)};
    for (std::size_t i = 0; i < pieces.size(); ++i) {
      const double end_s = i + 1 < pieces.size() ? pieces[i + 1].start_s : k_infinity;
      for (Eigen::Index axis = 0; axis < 3; ++axis)
        widen(reach, pieces[i], end_s - pieces[i].start_s, axis);
    }
    entry.tracks[body].reach = reach;
  }
}

}  // namespace sleight::browse
