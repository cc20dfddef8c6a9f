// Proposals that change throws of dice, and the ratios that make Algorithm 2.1 correct. In the
// thesis (2.4.4), a proposal changes one control point, one initial component, or everything.
//
//   `change_all` draws a state from p_w, including the table. The log q ratio is log p_w of the
//     present state minus log p_w of the candidate.
//   `change_die` draws the throw of one die, chosen uniformly. The ratio is computed like
//     `change_all`'s ratio, but for this die alone.
//   `change_start` adds a Gaussian to one random component of one die. An orientation turns by a
//     Gaussian angle about a uniform axis. This turn is symmetric in the uniform measure.
//   `change_control` chooses one of the table's control points uniformly, and adds a Gaussian to a
//     random field of this point. Restitution and friction are reflected at their ranges' ends. The
//     proposal is symmetric.
//   `change_contact` makes the change of `change_control` at a control point that influenced a
//     collision. First it chooses a collision with the table; the probability is proportional to
//     the preceding flight's duration. Then it chooses one of the sixteen points around the
//     collision; a point's weight there is the probability.
//
// The reverse of `change_contact` has a different probability, because another table causes other
// collisions. Let share(c) be the mean weight of point c over collisions. In this mean, a collision
// counts in proportion to its flight's duration. Then log q ratio = log share(c) of the candidate's
// collisions - log share(c) of the present collisions. The ratio is known after the simulation.
// Before the simulation, the ratio is at most log(4/9) - log share(c), since no weight of a bicubic
// B-spline exceeds (2/3)^2. If the candidate doesn't touch the point, there is no reverse proposal.
//
// Throws are chaotic: for a small effect on the end, an early change must be far smaller than a
// late change, and the right size differs from throw to throw. So a step's standard deviation is
// the configured maximum, halved several times. The number of halvings is drawn uniformly,
// independently of the state.
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

/// A control point that influenced collisions with the table, and its mean weight in the
/// collisions.
struct ContactShare {
  GridIndex index;
  double share = 0;
  friend bool operator==(const ContactShare&, const ContactShare&) = default;
};
/// Ascending by index. Shares add up to 1 minus the weight of the apron.
using ContactShares = std::vector<ContactShare>;

/// Returns 0 if `contacts` don't contain the index.
double share_of(const ContactShares& contacts, GridIndex index);

/// Upper bound for a weight or a mean of weights. It allows for rounding.
inline constexpr double k_share_max = 4.0 / 9.0 + 1e-9;

/// Multiplies step sizes by `scales` (by kind; empty: 1).
sampling::Proposal<State> propose(const Parameters& parameters, const State& state,
                                  const ContactShares& contacts, std::span<const double> scales,
                                  random::Stream& stream);

/// Returns change_contact's log q ratio, given the candidate's collisions. REQUIRES: the candidate
/// is a change_contact proposal from `state` and `contacts`.
double contact_log_q_ratio(const State& state, const ContactShares& contacts,
                           const State& candidate, const ContactShares& candidate_contacts);

/// Reflects x at the range's ends until x is in the range. REQUIRES: the range isn't constant.
double reflected(double x, const Range& range);

}  // namespace sleight::worlds::dice
