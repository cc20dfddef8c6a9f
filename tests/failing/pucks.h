// A made-up world, for tests of adding a world. A puck is pushed along the ice and hits a second
// puck. The second puck must come to rest at a target. The test programs contain this world and the
// failing ball. Clients, service and common contain nothing specific to this world.
//
//   Random variables: the first puck's speed and the pucks' gap, normal and independent.
//   Outcome: the x at which the second puck rests.
//   Density: log p_c = -1/2 ((x - target) / sigma)^2.
//   Satisfied: |x - target| <= tolerance.
//
// Pucks are square, slide along x without turning, slow down by friction, and transfer their speed
// at the hit. The motion is computed in closed form. Thread safety: immutable after construction.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "common/archive/world_layout.h"
#include "common/base/bytes.h"
#include "common/random/stream.h"
#include "common/request/direction_request.h"
#include "worker/sampling/target.h"

namespace sleight::failing {

struct PuckParameters {
  double friction = 0.05;
  double target_m = 1.5;
  double sigma_m = 0.1;
  double tolerance_m = 0.1;
};

/// The result of a push.
struct PuckMotion {
  double deceleration_mps2 = 0;
  double first_rest_s = 0;
  double first_rest_m = 0;
  bool is_hit = false;  ///< the first puck then rests at the hit
  double hit_mps = 0;   ///< the second puck's speed after the hit
  double second_rest_s = 0;
  double second_rest_m = 0;
};

class Pucks {
 public:
  /// The first puck's speed in m/s, and the gap between the pucks' sides in m.
  using State = std::array<double, 2>;
  using Outcome = PuckMotion;

  explicit Pucks(const PuckParameters& parameters) : parameters_(parameters) {}
  const PuckParameters& parameters() const { return parameters_; }

  State draw_prior(random::Stream& stream) const;
  double log_prior(const State& state) const;
  PuckMotion simulate(const State& state) const;
  double log_constraint(const PuckMotion& motion) const;
  bool satisfied(const PuckMotion& motion) const;
  sampling::Proposal<State> propose(const State& state, std::span<const double> scales,
                                    random::Stream& stream) const;
  bool has_scale(std::uint32_t /*kind*/) const { return true; }
  std::uint32_t proposal_kinds() const { return 1; }
  base::Bytes encode(const State& state) const;
  std::optional<State> decode(base::BytesView bytes) const;
  std::size_t owned_bytes(const State&, const Outcome&) const { return 0; }
  std::vector<double> outcome_values(const PuckMotion& motion) const;

 private:
  PuckParameters parameters_;
};

static_assert(sampling::ScalesProposals<Pucks>);

request::WorldBinding pucks_binding();
std::unique_ptr<archive::StateReader> make_pucks_reader(const PuckParameters& parameters);

}  // namespace sleight::failing
