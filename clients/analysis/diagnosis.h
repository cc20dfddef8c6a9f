// The diagnosis of an archive by `sleight diagnose`: whether its chains have mixed, and why not.
//
// Idea. Only draws of one Markov chain can be judged. Parallel tempering adapts between rounds, so
// only the draws of one round are judged (see tempering.h). Plain chains never adapt. Only the
// second half of a plain chain is judged, since the first half leads away from the prior. Methods
// with a burn-in adapt before their first draw, so all draws are judged. State variables are judged
// only at scans whose states are archived.
//
// If each draw ends its own tour, the draws are independent. All measures are then good even if
// tours are too short, so a run with tours is never reported as mixed. Annealed importance sampling
// has independent, weighted draws. Only the effective size of these draws is judged.
//
// If a state's log_constraint is -inf, its probability is 0 at inverse temperature 1. A chain that
// has left such states never returns to one. So -inf is treated as a value below all others, and
// even one such state means that the chains have not mixed. A state variable or an outcome is NaN
// if it doesn't apply. NaN is also treated as the least value, but is no sign of poor mixing.
//
// The caller passes the measures (Rules), because clients don't depend on the sampling code.
// Archives are untrusted: invalid content throws ExitCode::bad_archive.
#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "clients/analysis/after_burn_in.h"
#include "clients/analysis/scalar_draws.h"
#include "clients/analysis/tempering.h"
#include "common/archive/model.h"
#include "common/archive/summary.h"

namespace sleight::analysis {

inline constexpr double k_not_known = std::numeric_limits<double>::quiet_NaN();

/// The verdict on one scalar. NaN: unknown.
struct Verdict {
  double mean = k_not_known;
  double sd = k_not_known;
  double mcse = k_not_known;  ///< standard error of the mean
  double r_hat = k_not_known;
  double ess_bulk = k_not_known;
  double ess_tail = k_not_known;
  bool constant = false;
  std::vector<std::string> complaints;  ///< sentences that begin with the scalar's name
};

/// Draw d of chain c is values[c * draws + d].
struct ScalarDraws {
  std::span<const double> values;
  std::size_t chains = 1;
  std::size_t draws = 0;
};

/// The rules by which scalars are judged. All functions are set.
struct Rules {
  std::size_t draws_min = 0;  ///< minimum per chain
  std::function<double(std::size_t chains)> ess_wanted;
  std::function<Verdict(std::string_view name, const ScalarDraws&)> judge;
};

struct ScalarReport {
  std::string name;
  Verdict verdict;
  StandIns not_finite;  ///< if any, mean and sd are of the finite values and mcse is NaN
};

/// Maximum listed entries of an array. For larger arrays, only the worst entries are listed.
inline constexpr std::size_t k_entries_listed_max = 10;

struct VariableReport {
  std::string name;
  std::uint64_t entries = 0;
  std::uint64_t judged = 0;            ///< the first entries
  std::uint64_t failing = 0;           ///< among the judged
  std::vector<ScalarReport> listed{};  ///< all in order, or the worst first
};

struct KindReport {
  std::string name;
  std::uint64_t proposed = 0;
  std::uint64_t accepted = 0;
};

struct LadderReport {
  double barrier = 0;
  double round_trips = 0;
  double predicted_round_trips = 0;
  double restarts = 0;
  Ladder levels;
};

struct TemperingReport {
  std::size_t round = 0;  ///< counted from 1
  std::size_t rounds = 0;
  bool burn_in = false;  ///< the draws follow the burn-in that has these rounds
  std::vector<LadderReport> ladders;
};

/// Minimum effective size, all chains together.
inline constexpr double k_effective_size_min = 100;

struct WeightsReport {
  double effective_size = 0;         ///< all chains together
  CombinedEstimate log_z;            ///< without an error if there are doubts (odds_doubts.h)
  CombinedEstimate log_p_satisfied;  ///< without an error if there are doubts
  std::vector<AscentReport> chains;
};

enum class JudgedDraws : std::uint8_t {
  second_half,
  round,     ///< draws of a round, in which the ladder and step sizes are fixed
  all,       ///< all draws, after a burn-in
  tours,     ///< each draw ends its own tour: independent, so mixing can't be judged
  weighted,  ///< all draws, by their weights only
};

struct Diagnosis {
  std::string world;
  std::string warning;  ///< as stored in the archive
  std::uint64_t chains = 0;
  std::uint64_t scans = 0;  ///< per chain: draws
  Round judged;             ///< the judged scans
  JudgedDraws which = JudgedDraws::second_half;
  std::vector<ScalarReport> scalars;
  std::uint64_t states = 0;  ///< per chain: archived in the judged scans
  std::vector<VariableReport> variables;
  std::uint64_t satisfied = 0;         ///< scans, over all chains
  std::uint64_t satisfied_judged = 0;  ///< among the judged scans
  std::uint64_t solutions = 0;         ///< distinct (chain, lineage) of satisfied scans
  bool solutions_more = false;         ///< there are more than the limit for counting
  double simulations = 0;              ///< whole run, all temperatures; NaN: unknown
  std::vector<KindReport> kinds;       ///< of the judged scans, at inverse temperature 1
  std::optional<TemperingReport> tempering;
  std::vector<WalkReport> walks;              ///< simulated tempering, by chain
  std::vector<TransitionReport> transitions;  ///< tempered transitions, by chain
  std::optional<WeightsReport> weights;       ///< annealed importance sampling
  std::vector<std::string> notes;             ///< what was left out, and explanations of numbers
  std::vector<std::string> reasons;           ///< against mixing; empty: none found
  bool mixed() const { return reasons.empty(); }
};

/// Returns the reason why an archive's draws can't be judged as chains. Empty: they can.
std::string why_not_diagnosed(const archive::Source& source, const archive::Summary& summary);

/// Throws base::Error(usage) if why_not_diagnosed() returns a reason.
Diagnosis diagnosis_of(const archive::Source& source, const Rules& rules);

}  // namespace sleight::analysis
