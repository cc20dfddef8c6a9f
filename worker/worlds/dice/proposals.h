// Proposals that change throws of dice (thesis 2.4.4: one control point, one initial component, or
// everything), with the ratios that make Algorithm 2.1 correct.
//
//   `change_all` draws a state from p_w, including the table. The log q ratio is log p_w of the
//     present state minus log p_w of the candidate.
//   `change_die` draws the throw of one die, chosen uniformly. The ratio is computed as for
//     `change_all`, but for this die alone.
//   `change_start` adds a Gaussian to one random component of one die. An orientation is turned by
//     a Gaussian angle about a uniform axis, which is symmetric in the uniform measure.
//   `change_control` adds a Gaussian to one random field of one control point of the table, chosen
//     uniformly. Restitution and friction are reflected at their ranges' ends. The proposal is
//     symmetric.
//   `change_contact` changes a control point that influenced a collision, in the same way as
//     `change_control`. First a collision with the table is chosen, with probability proportional
//     to the preceding flight's duration. Then one of the sixteen points around it is chosen, with
//     its weight there as the probability.
//
// The reverse of `change_contact` has a different probability, because another table causes other
// collisions. Let share(c) be the mean weight of point c over collisions, each weighted by its
// flight's duration. Then log q ratio = log share(c) of the candidate's collisions - log share(c)
// of the present collisions. The ratio is known after the simulation. Before the simulation, the
// ratio is at most log(4/9) - log share(c), since no weight of a bicubic B-spline exceeds (2/3)^2.
// If the candidate doesn't touch the point, there is no reverse proposal.
//
// Throws are chaotic: for a small effect on the end, an early change must be far smaller than a
// late one, and the right size differs from throw to throw. So a step's standard deviation is the
// configured maximum, halved a uniformly drawn number of times, independently of the state.
//
// If a kind finds nothing to change, it proposes the present state.
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

inline bool has_scale(Kind kind) {
  return kind != Kind::change_all && kind != Kind::change_die;
}

/// A control point of the table that influenced collisions, and its mean weight in them.
struct ContactShare {
  GridIndex index;
  double share = 0;
  friend bool operator==(const ContactShare&, const ContactShare&) = default;
};
/// Ascending by index. Shares add up to 1 minus the weight of the apron.
using ContactShares = std::vector<ContactShare>;

/// Returns 0 if `contacts` don't contain the index.
double share_of(const ContactShares& contacts, GridIndex index);

/// Upper bound for a weight and for a mean of weights, rounding included.
inline constexpr double k_share_max = 4.0 / 9.0 + 1e-9;

/// Multiplies step sizes by `scales` (by kind; empty: 1).
sampling::Proposal<State> propose(const Parameters& parameters, const State& state,
                                  const ContactShares& contacts, std::span<const double> scales,
                                  random::Stream& stream);

/// Returns change_contact's log q ratio once the candidate's collisions are known.
/// REQUIRES: the candidate is a change_contact proposal from the state with these contacts.
double contact_log_q_ratio(const State& state, const ContactShares& contacts,
                           const State& candidate, const ContactShares& candidate_contacts);

/// Returns x folded back into the range, as often as needed. REQUIRES: the range isn't constant.
double reflected(double x, const Range& range);

}  // namespace sleight::worlds::dice
