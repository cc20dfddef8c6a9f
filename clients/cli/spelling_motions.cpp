#include "clients/cli/spelling_motions.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <string_view>
#include <utility>

#include "clients/cli/kept_animations.h"
#include "common/archive/format.h"

namespace sleight::cli {
namespace {

/// Most segments of an animation: four times what 480 balls with 500 bounces each have.
constexpr std::uint64_t k_segments_max = 1'000'000;

constexpr double k_mm_per_m = 1000;

PlaceMm row_mm(const std::vector<double>& values_m, std::size_t row) {
  return {k_mm_per_m * values_m[3 * row], k_mm_per_m * values_m[3 * row + 1],
          k_mm_per_m * values_m[3 * row + 2]};
}

}  // namespace

std::optional<PlaceMm> BallMotion::place_at(double time_s) const {
  const Piece* found = piece_in_force(pieces_, time_s);
  if (found == nullptr) return std::nullopt;
  const Piece& piece = *found;
  const double t = time_s - piece.start_s;
  PlaceMm place = piece.position_mm;
  for (std::size_t axis = 0; axis < place.size(); ++axis)
    place[axis] += piece.velocity_mmps[axis] * t + 0.5 * piece.acceleration_mmps2[axis] * t * t;
  return place;
}

std::vector<BallMotion> read_motions(const archive::Source& source, std::size_t animation,
                                     std::uint64_t balls) {
  const Rows rows = segments_of(source, animation, k_segments_max);
  const std::string_view group = drawn_group(source);
  const auto column = [&](std::string_view name, std::uint64_t width) {
    return read_rows(source, group, name, width, rows);
  };
  const std::vector<double> ball = column(body_column(source, "moving_ball"), 1);
  const std::vector<double> start_s = column("start_s", 1);
  const std::vector<double> position_m = column("position_m", 3);
  const std::vector<double> velocity_mps = column("velocity_mps", 3);
  const std::vector<double> acceleration_mps2 = column("acceleration_mps2", 3);
  const auto refuse = [&](const char* reason) { refuse_animation(source, animation, reason); };
  std::map<std::uint64_t, BallMotion> motions;
  for (std::size_t row = 0; row < rows.count; ++row) {
    // The comparisons are false for NaN: what is not trusted is cast afterwards.
    if (!(ball[row] >= 0 && ball[row] < static_cast<double>(balls)))
      refuse("moves balls that its request doesn't have");
    const auto number = static_cast<std::uint64_t>(ball[row]);
    BallMotion& motion = motions.try_emplace(number, number).first->second;
    const bool in_order =
        std::isfinite(start_s[row]) &&
        (motion.pieces().empty() || motion.pieces().back().start_s <= start_s[row]);
    if (!in_order) refuse("has segments that are not in the order of time");
    motion.append({.start_s = start_s[row],
                   .position_mm = row_mm(position_m, row),
                   .velocity_mmps = row_mm(velocity_mps, row),
                   .acceleration_mmps2 = row_mm(acceleration_mps2, row)});
  }
  if (motions.empty()) refuse("moves no ball");
  std::vector<BallMotion> out;
  for (auto& [number, motion] : motions)
    out.push_back(std::move(motion));
  return out;
}

}  // namespace sleight::cli
