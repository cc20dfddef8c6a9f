// Metropolis-Hastings kernels, each with one known bug. A test of samplers must reject at least one
// of these kernels.
#pragma once

#include <array>
#include <cstdint>

#include "tests/statistical/support/ball_fixture.h"

namespace sleight::statistical {

enum class Bug {
  none,
  always_accepts,
  ratio_inverted,
  prior_forgotten,
  constraint_forgotten,
  wrong_temperature,
  independence_draw_as_symmetric,
  lopsided_offset,
  shrinking_proposal,
  old_density_kept,
  random_number_reused,
};

inline constexpr std::array k_bugs = {Bug::always_accepts,    Bug::ratio_inverted,
                                      Bug::prior_forgotten,   Bug::constraint_forgotten,
                                      Bug::wrong_temperature, Bug::independence_draw_as_symmetric,
                                      Bug::lopsided_offset,   Bug::shrinking_proposal,
                                      Bug::old_density_kept,  Bug::random_number_reused};

const char* name_of(Bug bug);

/// Makes one iteration. If the bug is in the kernel's inputs, runs the real kernel on wrong inputs.
/// Otherwise runs a copy of the kernel that differs in one line.
void step(const Ball& ball, Bug bug, double beta, const sampling::ChainStreams& streams,
          std::uint64_t iteration, BallSample& current);

}  // namespace sleight::statistical
