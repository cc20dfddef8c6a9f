// A small spelling world, and exact draws of p_w p_c^beta, for tests of kernels.
#pragma once

#include "common/math/elementary.h"
#include "worker/sampling/metropolis_hastings.h"
#include "worker/worlds/spelling/spelling.h"

namespace sleight::statistical {

using Spelling = worlds::spelling::Spelling;
using SpellingSample = sampling::Sample<Spelling>;

/// Returns a world in which two balls must fill two bins. Lambda is small, so that exact draws are
/// cheap.
inline Spelling world_with(worlds::spelling::Kernel kernel) {
  worlds::spelling::Parameters parameters;
  parameters.pattern = worlds::spelling::pattern_of_rows("##").value();
  parameters.constraint.log_lambda = 1.2;
  parameters.proposal.change_all = 0.2;
  parameters.proposal.change_vertices = 0.2;
  parameters.proposal.change_ball = 0.2;
  parameters.proposal.disable_balls = 0.2;
  parameters.proposal.enable_balls = 0.2;
  parameters.proposal.vertex_probability = 0.5;
  parameters.proposal.vertex_sd_m = 0.0001;
  parameters.proposal.kernel = kernel;
  return Spelling(parameters);
}

/// Adds aimed drops to the proposals of A.2.2 (aimed_drops.h).
inline worlds::spelling::Parameters parameters_with_aims() {
  worlds::spelling::Parameters parameters =
      world_with(worlds::spelling::Kernel::correct).parameters();
  parameters.proposal.change_all = 0.05;
  parameters.proposal.change_vertices = 0.05;
  parameters.proposal.change_ball = 0.1;
  parameters.proposal.disable_balls = 0.1;
  parameters.proposal.enable_balls = 0.1;
  parameters.proposal.aim_ball = 0.35;
  parameters.proposal.scatter_ball = 0.25;
  return parameters;
}

/// Also adds solo steps, which are first tested by simulating balls alone (solo_balls.h).
inline worlds::spelling::Parameters parameters_with_solo_steps() {
  worlds::spelling::Parameters parameters = parameters_with_aims();
  parameters.proposal.solo_steps = 3;
  return parameters;
}

/// Draws exactly. Rejection is possible because p_c is at most lambda^2.
inline SpellingSample exact_draw(const Spelling& world, double beta, random::Stream& stream) {
  const double most = world.balls() * world.parameters().constraint.log_lambda;
  while (true) {
    SpellingSample sample = sampling::evaluate(
        world, draw_state(world.prior(), worlds::spelling::Kernel::correct, stream));
    const double u = stream.uniform();
    if (math::log(u) < beta * (sample.log_constraint - most)) return sample;
  }
}

}  // namespace sleight::statistical
