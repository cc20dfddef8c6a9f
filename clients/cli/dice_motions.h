// How dice move in an animation: segments of uniformly accelerated flight that turn about a fixed
// axis, a die's last one at rest.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "clients/cli/die_drawing.h"
#include "common/archive/model.h"

namespace sleight::cli {

class DieMotion {
 public:
  /// One segment, from its start until the next one's.
  struct Piece {
    double start_s = 0;
    math::Vec3 position_mm{0, 0, 0};
    math::Vec3 velocity_mmps{0, 0, 0};
    math::Vec3 acceleration_mmps2{0, 0, 0};
    math::Quat orientation = math::Quat::Identity();  ///< of the numbered die
    math::Vec3 spin_radps{0, 0, 0};                   ///< in the table's frame
  };

  /// `die`: counted from 0.
  explicit DieMotion(std::uint64_t die) : die_(die) {}
  /// REQUIRES: pieces come in the order of their starts, and have finite numbers.
  void append(const Piece& piece) { pieces_.push_back(piece); }

  std::uint64_t die() const { return die_; }
  const std::vector<Piece>& pieces() const { return pieces_; }
  /// When it is let go, and when it came to rest. REQUIRES: it has a piece.
  double start_s() const { return pieces_.front().start_s; }
  double rest_s() const { return pieces_.back().start_s; }
  /// Nothing before it is let go.
  std::optional<DiePose> pose_at(double time_s) const;
  /// REQUIRES: it has a piece.
  DiePose last_pose() const { return *pose_at(rest_s()); }

 private:
  std::uint64_t die_;
  std::vector<Piece> pieces_;
};

/// The motions of one kept animation of so many dice, in the order of dice. Throws
/// base::Error(bad_archive) on what can be no motion of them.
std::vector<DieMotion> read_dice_motions(const archive::Source& source, std::size_t animation,
                                         std::uint64_t dice);

}  // namespace sleight::cli
