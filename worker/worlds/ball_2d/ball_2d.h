// The world of the 2D ball (thesis 2.2, 2.4.1): which normals make a dropped ball land near a
// place?
//
//   `random variables`: normals theta_1 .. theta_n, independent N(0, sd) tilts from the vertical.
//   `log p_w`: sum of the normals' log densities, normalised.
//   `outcome`: where and when the ball lands. The landing is collision n + 1.
//   `log p_c`: -1/2 ((x - target) / sigma)^2, so p_c is at most 1.
//   `satisfied`: |x - target| <= tolerance.
//   `proposal`: Algorithm 2.2. Each normal changes with some probability, by a uniform number in
//     (-w, w).
// Thread-safe: immutable after construction.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "common/base/bytes.h"
#include "common/random/stream.h"
#include "worker/sampling/target.h"
#include "worker/worlds/ball_2d/motion.h"
#include "worker/worlds/ball_2d/parameters.h"

namespace sleight::worlds::ball_2d {

class Ball2d {
 public:
  using State = NormalAngles;
  using Outcome = Landing;

  explicit Ball2d(const Parameters& parameters) : parameters_(parameters) {}

  const Parameters& parameters() const { return parameters_; }

  State draw_prior(random::Stream& stream) const;
  double log_prior(const State& normals) const;
  Landing simulate(const State& normals) const;
  double log_constraint(const Landing& landing) const;
  bool satisfied(const Landing& landing) const;
  /// Multiplies the proposal's half width by the scale.
  sampling::Proposal<State> propose(const State& normals, std::span<const double> scales,
                                    random::Stream& stream) const;
  bool has_scale(std::uint32_t /*kind*/) const { return true; }
  std::uint32_t proposal_kinds() const { return 1; }

  /// Encodes a state as one double per collision. `decode` refuses any other length.
  base::Bytes encode(const State& normals) const;
  std::size_t owned_bytes(const State&, const Outcome&) const { return 0; }
  std::optional<State> decode(base::BytesView bytes) const;

  /// Returns the values in the order of layout().outcomes.
  std::vector<double> outcome_values(const Landing& landing) const;

 private:
  Parameters parameters_;
};

static_assert(sampling::ScalesProposals<Ball2d>);

}  // namespace sleight::worlds::ball_2d
