#include "clients/cli/dice_motions.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <string_view>
#include <utility>

#include "clients/cli/kept_animations.h"
#include "common/archive/format.h"

namespace sleight::cli {
namespace {

using math::Quat;
using math::Vec3;

/// Most segments of an animation: some hundred times what twenty dice have.
constexpr std::uint64_t k_segments_max = 1'000'000;

/// Larger numbers, in SI units, are no motion of dice.
constexpr double k_number_max = 1e6;
constexpr double k_norm_off_max = 1e-3;
constexpr double k_mm_per_m = 1000;

/// The columns of an animation's segments.
struct Segments {
  std::size_t count = 0;
  std::vector<double> die;
  std::vector<double> start_s;
  std::vector<double> position_m;
  std::vector<double> velocity_mps;
  std::vector<double> acceleration_mps2;
  std::vector<double> orientation;
  std::vector<double> spin_radps;

  /// But for the dice's numbers, which are judged one by one.
  bool is_sane() const {
    const auto sane = [](const std::vector<double>& values) {
      return std::ranges::all_of(
          values, [](double value) { return std::abs(value) <= k_number_max; });  // false of NaN
    };
    return sane(start_s) && sane(position_m) && sane(velocity_mps) && sane(acceleration_mps2) &&
           sane(orientation) && sane(spin_radps);
  }
  Quat orientation_at(std::size_t row) const {
    const double* q = &orientation[4 * row];
    return {q[0], q[1], q[2], q[3]};
  }
};

Segments read_segments(const archive::Source& source, std::size_t animation) {
  const Rows rows = segments_of(source, animation, k_segments_max);
  const std::string_view group = drawn_group(source);
  const auto column = [&](std::string_view name, std::uint64_t width) {
    return read_rows(source, group, name, width, rows);
  };
  return {.count = rows.count,
          .die = column(body_column(source, "moving_die"), 1),
          .start_s = column("start_s", 1),
          .position_m = column("position_m", 3),
          .velocity_mps = column("velocity_mps", 3),
          .acceleration_mps2 = column("acceleration_mps2", 3),
          .orientation = column("orientation", 4),
          .spin_radps = column("angular_velocity_radps", 3)};
}

Vec3 vector_at(const std::vector<double>& values, std::size_t row) {
  return {values[3 * row], values[3 * row + 1], values[3 * row + 2]};
}

bool is_rotation(const Quat& q) {
  const double square = q.w() * q.w() + q.x() * q.x() + q.y() * q.y() + q.z() * q.z();
  return std::abs(square - 1) <= k_norm_off_max;
}

}  // namespace

std::optional<DiePose> DieMotion::pose_at(double time_s) const {
  const Piece* found = piece_in_force(pieces_, time_s);
  if (found == nullptr) return std::nullopt;
  const Piece& piece = *found;
  const double t = time_s - piece.start_s;
  const Quat turn = math::quaternion_of_rotation_vector(piece.spin_radps * t);
  return DiePose{.centre_mm = piece.position_mm + t * piece.velocity_mmps +
                              0.5 * t * t * piece.acceleration_mmps2,
                 .orientation = math::normalized(math::composed(turn, piece.orientation))};
}

std::vector<DieMotion> read_dice_motions(const archive::Source& source, std::size_t animation,
                                         std::uint64_t dice) {
  const Segments segments = read_segments(source, animation);
  const auto refuse = [&](const char* reason) { refuse_animation(source, animation, reason); };
  if (!segments.is_sane()) refuse("has numbers that no motion of dice has");
  std::map<std::uint64_t, DieMotion> motions;
  for (std::size_t row = 0; row < segments.count; ++row) {
    // The comparisons are false for NaN: what is not trusted is cast afterwards.
    const double die = segments.die[row];
    if (!(die >= 0 && die < static_cast<double>(dice)))
      refuse("moves dice that its request doesn't have");
    const auto number = static_cast<std::uint64_t>(die);
    DieMotion& motion = motions.try_emplace(number, number).first->second;
    const double start_s = segments.start_s[row];
    if (!motion.pieces().empty() && motion.rest_s() > start_s)
      refuse("has segments that are not in the order of time");
    const Quat orientation = segments.orientation_at(row);
    if (!is_rotation(orientation)) refuse("has orientations that are no rotations");
    motion.append({.start_s = start_s,
                   .position_mm = k_mm_per_m * vector_at(segments.position_m, row),
                   .velocity_mmps = k_mm_per_m * vector_at(segments.velocity_mps, row),
                   .acceleration_mmps2 = k_mm_per_m * vector_at(segments.acceleration_mps2, row),
                   .orientation = math::normalized(orientation),
                   .spin_radps = vector_at(segments.spin_radps, row)});
  }
  if (motions.empty()) refuse("moves no die");
  std::vector<DieMotion> out;
  for (auto& [number, motion] : motions)
    out.push_back(std::move(motion));
  return out;
}

}  // namespace sleight::cli
