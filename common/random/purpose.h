// What random numbers are drawn for: the one list, so that two uses never share a stream.
//
// The numbers are part of the archive's meaning (the same seed gives the same animations): a number
// is never changed and never reused; a new purpose takes the next one. 0 is no purpose, so a key
// that forgot to name one is refused by Stream.
#pragma once

#include <cstdint>

namespace sleight::random {

enum class Purpose : std::uint32_t {
  prior = 1,         ///< a state drawn from the world model
  proposal = 2,      ///< the choice of a kind of proposal, and the candidate itself
  acceptance = 3,    ///< the uniform number of a Metropolis-Hastings decision
  swap = 4,          ///< the uniform number of a decision to swap two neighbours of a ladder
  scene = 5,         ///< a scene of the simulator's list: places and velocities
  start = 6,         ///< another place for a body that had no room at its start
  excursion = 7,     ///< the uniform number of a tempered transition's decision
  level = 8,         ///< which temperature simulated tempering moves to, and whether it does
  table = 9,         ///< a control point of a random surface: the seed is the surface's own key
  ground = 10,       ///< what the particles of an island share
  extension = 11,    ///< a particle's choice of a stage: the replica is the particle
  resampling = 12,   ///< which particle each of the next ones descends from
  particle = 13,     ///< which particle of an island is its draw
  search = 14,       ///< the tries of a search
  guide = 15,        ///< what a world learns of itself
  blind_throw = 16,  ///< throws that something found is compared with
  counted = 17,      ///< which of a chain's satisfying scans is its independent solution
  prior_draw = 18    ///< draws from the prior that stand beside a run's samples
};

}  // namespace sleight::random
