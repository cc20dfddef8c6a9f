// How throws of dice are changed (thesis 2.4.4: one control point, one initial component, or
// everything), with the ratios that make Algorithm 2.1 right.
//
//   change_all      a draw from p_w, table and all: log q ratio = log p_w of the present state less
//                   that of the candidate
//   change_die      one die, uniformly: its throw is drawn afresh; likewise, for that die
//   change_start    one random component of one die: plus a Gaussian; of the orientation, a turn by
//                   a Gaussian angle about a uniform axis, which is symmetric with respect to the
//                   uniform measure on rotations
//   change_control  one random field of one control point of the table, uniformly: plus a Gaussian.
//                   Restitution and friction are reflected at the ends of their ranges, which is
//                   symmetric as well
//   change_contact  the same of a control point that mattered: one of the collisions of dice with
//                   the table, with a probability proportional to how long the die flew to it, then
//                   one of the sixteen points around it, with the probability of its weight there.
//                   Another table makes other collisions, so the way back has another probability:
//                   with share(c) the mean of the weight of point c over collisions, each weighed
//                   by its flight, log q ratio = log share(c) of the candidate's collisions - log
//                   share(c) of the present ones. It is known after the simulation, and is at most
//                   log(4/9) - log share(c), since no weight of a bicubic B-spline exceeds (2/3)^2.
//                   A point that the candidate doesn't touch has no way back.
//
// Throws are chaotic: what changes the end a little is far smaller early in a throw than late, and
// differs from throw to throw. So a step's standard deviation is the greatest that is asked for,
// halved some times, which number is drawn uniformly, and whatever the state is.
//
// A kind that finds nothing to change proposes the present state.
// Thread safety: pure functions.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/random/stream.h"
#include "worker/sampling/target.h"
#include "worker/worlds/dice/parameters.h"
#include "worker/worlds/dice/state.h"

namespace sleight::worlds::dice {

enum class Kind : std::uint8_t {
  change_all,
  change_die,
  change_start,
  change_control,
  change_contact
};
inline constexpr std::uint32_t k_kinds = 5;

/// Whether a kind has a size that can be tuned.
inline bool has_scale(Kind kind) {
  return kind != Kind::change_all && kind != Kind::change_die;
}

/// A control point of the table that collisions hung on, and the mean of its weight in them.
struct ContactShare {
  GridIndex index;
  double share = 0;
  friend bool operator==(const ContactShare&, const ContactShare&) = default;
};
/// In ascending order of places. Adds up to 1, less the weight of the apron.
using ContactShares = std::vector<ContactShare>;

/// 0 if it has none.
double share_of(const ContactShares& contacts, GridIndex index);

/// No weight is larger, nor is a mean of weights, rounding included.
inline constexpr double k_share_max = 4.0 / 9.0 + 1e-9;

/// Shares and sizes as the parameters and `scales` (by kind; empty: 1) have them.
sampling::Proposal<State> propose(const Parameters& parameters, const State& state,
                                  const ContactShares& contacts, std::span<const double> scales,
                                  random::Stream& stream);

/// Of change_contact, when the candidate's collisions are known.
/// REQUIRES: the candidate is a proposal of that kind from the state with these contacts.
double contact_log_q_ratio(const State& state, const ContactShares& contacts,
                           const State& candidate, const ContactShares& candidate_contacts);

/// Folded back into a range at its ends, as often as it takes. REQUIRES: the range isn't constant.
double reflected(double x, const Range& range);

}  // namespace sleight::worlds::dice
