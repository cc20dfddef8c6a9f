// What `sleight diagnose` finds out about an archive: whether its chains have mixed, and why not.
//
// Idea. Only draws of one Markov chain can be judged. Parallel tempering learns between rounds, so
// the draws of one round are judged (tempering.h says which); plain chains never change, and their
// second half is judged, the first being the way from the prior. What goes on after a burn-in has
// learnt before its first draw, and all its draws are judged. State variables are judged by their
// archived states of these scans.
//
// Where each draw ends a tour of its own, draws are independent, and all measures are good however
// little a tour has burnt in. So such a run is never said to have mixed.
//
// Draws of annealed importance sampling are no Markov chain: they are independent and have weights.
// Of them their effective size is judged, and nothing else.
//
// A state with log_constraint -inf has probability 0 at inverse temperature 1, and a chain that has
// left such states never goes back. So they take part as the least of all values, are counted, and
// are a reason in themselves: that chain is still on its way. Entries of state variables and
// outcomes that do not apply (NaN) take part in the same way, and are no reason.
//
// The measures come from outside (Rules), since clients know no sampling methods; a program's main
// joins them. Archives are untrusted: what can't be is refused with ExitCode::bad_archive.
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

/// Of one scalar. NaN where a number can't be given.
struct Verdict {
  double mean = k_not_known;
  double sd = k_not_known;
  double mcse = k_not_known;  ///< standard error of the mean
  double r_hat = k_not_known;
  double ess_bulk = k_not_known;
  double ess_tail = k_not_known;
  bool constant = false;
  std::vector<std::string> complaints;  ///< sentences that open with the scalar's name
};

/// Draw d of chain c is values[c * draws + d].
struct ScalarDraws {
  std::span<const double> values;
  std::size_t chains = 1;
  std::size_t draws = 0;
};

/// How scalars are judged. All functions are there.
struct Rules {
  std::size_t draws_min = 0;  ///< of each chain: fewer can't be judged
  std::function<double(std::size_t chains)> ess_wanted;
  std::function<Verdict(std::string_view name, const ScalarDraws&)> judge;
};

struct ScalarReport {
  std::string name;
  Verdict verdict;
  StandIns not_finite;  ///< where there are any, mean and sd are of the others and mcse is NaN
};

/// Entries of an array are listed up to here; of more, the worst ones.
inline constexpr std::size_t k_entries_listed_max = 10;

struct VariableReport {
  std::string name;
  std::uint64_t entries = 0;
  std::uint64_t judged = 0;            ///< the first so many
  std::uint64_t failing = 0;           ///< of the judged
  std::vector<ScalarReport> listed{};  ///< all in order, or the worst first
};

struct KindReport {
  std::string name;
  std::uint64_t proposed = 0;
  std::uint64_t accepted = 0;
};

/// Of one ladder in the judged round.
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
  bool burn_in = false;  ///< the draws came after it
  std::vector<LadderReport> ladders;
};

/// Independent draws of equal weight that those of all chains together must be worth.
inline constexpr double k_effective_size_min = 100;

struct WeightsReport {
  double effective_size = 0;         ///< of all chains together
  CombinedEstimate log_z;            ///< without an error where odds_doubts.h doubts it
  CombinedEstimate log_p_satisfied;  ///< likewise
  std::vector<AscentReport> chains;
};

/// Which draws are judged.
enum class JudgedDraws : std::uint8_t {
  second_half,
  round,     ///< in which neither ladder nor sizes change
  all,       ///< after a burn-in
  tours,     ///< one at the end of each: independent, so that nothing here says how far they got
  weighted,  ///< all, by their weights alone
};

struct Diagnosis {
  std::string world;
  std::string warning;  ///< the archive's own
  std::uint64_t chains = 0;
  std::uint64_t scans = 0;  ///< of each chain: draws
  Round judged;             ///< of these
  JudgedDraws which = JudgedDraws::second_half;
  std::vector<ScalarReport> scalars;
  std::uint64_t states = 0;  ///< of each chain, archived in the judged scans
  std::vector<VariableReport> variables;
  std::uint64_t satisfied = 0;         ///< of all scans of all chains
  std::uint64_t satisfied_judged = 0;  ///< of the judged ones
  std::uint64_t solutions = 0;         ///< distinct (chain, lineage) of the satisfied
  bool solutions_more = false;         ///< more than can be counted here
  double simulations = 0;              ///< of the run, at all temperatures; NaN: unknown
  std::vector<KindReport> kinds;       ///< of the judged scans, at inverse temperature 1
  std::optional<TemperingReport> tempering;
  std::vector<WalkReport> walks;              ///< of simulated tempering, by chain
  std::vector<TransitionReport> transitions;  ///< of tempered transitions, by chain
  std::optional<WeightsReport> weights;       ///< of annealed importance sampling
  std::vector<std::string> notes;             ///< what was left out, what numbers mean here
  std::vector<std::string> reasons;  ///< why the chains have not mixed; empty: nothing says so
  bool mixed() const { return reasons.empty(); }
};

/// Why an archive's draws are nothing that chains could have mixed; empty: they are chains'.
std::string why_not_diagnosed(const archive::Source& source, const archive::Summary& summary);

/// Throws base::Error(usage) where why_not_diagnosed says why.
Diagnosis diagnosis_of(const archive::Source& source, const Rules& rules);

}  // namespace sleight::analysis
