// The balls of one kept spelling animation, out of an archive's segments.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "common/archive/model.h"

namespace sleight::cli {

/// In the box's frame: x to the right, y to the back, z up, from the middle of the box on the
/// floor's rim.
using PlaceMm = std::array<double, 3>;

/// A ball from its drop on. Positions are NaN or infinite where a damaged archive's are.
class BallMotion {
 public:
  /// A piece of the motion: a parabola from its start to the next piece's.
  struct Piece {
    double start_s = 0;
    PlaceMm position_mm{};
    PlaceMm velocity_mmps{};
    PlaceMm acceleration_mmps2{};
  };

  explicit BallMotion(std::uint64_t ball) : ball_(ball) {}
  void append(const Piece& piece) { pieces_.push_back(piece); }

  /// 0, 1, ... in the order of drops.
  std::uint64_t ball() const { return ball_; }
  std::span<const Piece> pieces() const { return pieces_; }
  /// The last piece in force then; nothing before the drop.
  std::optional<PlaceMm> place_at(double time_s) const;

 private:
  std::uint64_t ball_;
  std::vector<Piece> pieces_;
};

/// The balls of a kept animation in ascending order. REQUIRES: there is such an animation. Throws
/// base::Error(bad_archive) when the segments are not those of `balls` balls at most, a ball's are
/// not in the order of finite times, or there is none.
std::vector<BallMotion> read_motions(const archive::Source& source, std::size_t animation,
                                     std::uint64_t balls);

}  // namespace sleight::cli
