// Lists all uses of random numbers. Two uses never share a stream.
//
// The numbers are part of the archive's meaning (the same seed yields the same animations). Never
// change or reuse a number; a new purpose gets the next one. Stream refuses a missing purpose, 0.
#pragma once

#include <cstdint>

namespace sleight::random {

enum class Purpose : std::uint32_t {
  prior = 1,         ///< A state drawn from the world model.
  proposal = 2,      ///< The kind of proposal, and the candidate itself.
  acceptance = 3,    ///< Accepting a Metropolis-Hastings candidate.
  swap = 4,          ///< Deciding a swap of two neighbours in a ladder.
  scene = 5,         ///< A physics scene of the simulator's list: places and velocities.
  start = 6,         ///< Another place for a body without room at its start.
  excursion = 7,     ///< Accepting a tempered transition.
  level = 8,         ///< The level to which simulated tempering moves, and its acceptance.
  table = 9,         ///< A control point of a random surface; the seed is the surface's own key.
  ground = 10,       ///< The ground that an island's particles share.
  extension = 11,    ///< A particle's choice at a stage; the replica is the particle.
  resampling = 12,   ///< Ancestors of resampled particles.
  particle = 13,     ///< The particle that is an island's draw.
  search = 14,       ///< The tries of a search.
  guide = 15,        ///< A world's guide.
  blind_throw = 16,  ///< Blind throws, with which finds are compared.
  counted = 17,      ///< The satisfying scan that is a chain's independent solution.
  prior_draw = 18,   ///< Prior draws beside a run's samples.
  noise = 19         ///< An impact's noise; the seed is the state's key.
};

}  // namespace sleight::random
