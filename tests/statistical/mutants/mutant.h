// A sampler with one known mistake. A mutant is the real code, but one part is replaced: the world
// (with wrong densities or proposals), the kernel's step, a formula of tempering
// (replaced_formulas.h), the worker, or the plan.
#pragma once

#include <cmath>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "common/plan/plan.h"
#include "tests/statistical/support/toy_worlds.h"
#include "tests/unit/worker/sampling/replaced_formulas.h"
#include "worker/sampling/metropolis_hastings.h"

namespace sleight::statistical {

/// The world's wrong answers. If a function is empty, the world answers correctly.
struct Lies {
  std::function<void(std::uint32_t from, sampling::Proposal<std::uint32_t>&)> proposal{};
  std::function<std::uint32_t(random::Stream&)> prior_draw{};
  std::function<double(double)> log_prior{};
  std::function<double(double)> log_constraint{};
  std::function<bool(std::uint32_t)> satisfied{};
};

/// The rugged ring with a second kind of proposal: a prior draw, which may be at any place.
struct Ring : RuggedRing {
  static constexpr double k_independent_share = 0.3;
  double independent_share = k_independent_share;
  Lies lies;

  State draw_prior(random::Stream& stream) const {
    return lies.prior_draw ? lies.prior_draw(stream) : RuggedRing::draw_prior(stream);
  }
  double log_prior(const State& state) const {
    const double truth = RuggedRing::log_prior(state);
    return lies.log_prior ? lies.log_prior(truth) : truth;
  }
  double log_constraint(const Outcome& outcome) const {
    const double truth = RuggedRing::log_constraint(outcome);
    return lies.log_constraint ? lies.log_constraint(truth) : truth;
  }
  bool satisfied(const Outcome& outcome) const {
    return lies.satisfied ? lies.satisfied(outcome) : RuggedRing::satisfied(outcome);
  }
  std::uint32_t proposal_kinds() const { return 2; }
  sampling::Proposal<State> propose(const State& state, random::Stream& stream) const {
    sampling::Proposal<State> proposal;
    if (stream.uniform() < independent_share) {
      const State candidate = RuggedRing::draw_prior(stream);
      proposal = {.candidate = candidate,
                  .log_q_ratio = RuggedRing::log_prior(state) - RuggedRing::log_prior(candidate),
                  .kind = 1};
    } else {
      proposal = RuggedRing::propose(state, stream);
    }
    if (lies.proposal) lies.proposal(state, proposal);
    return proposal;
  }
};
static_assert(run::World<Ring>);

/// Replaces metropolis_hastings_step.
using Step = std::function<void(const Ring&, double beta, const sampling::ChainStreams&,
                                std::uint64_t iteration, sampling::Sample<Ring>&)>;

/// Replaces a worker's run; `right` is the real worker.
using Run = std::function<plan::UnitResult(const plan::UnitWorker& right, const plan::Unit&,
                                           base::BytesView state)>;

/// Changes messages between a plan and its executor.
struct OnTheWay {
  std::function<void(plan::Unit&)> handed_out{};
  std::function<void(const plan::ReplicaKey&, std::vector<plan::ScanRecord>&)> taken_in{};
};

/// Name of a check (checks.h).
enum class CheckId {
  kernel_keeps,
  kernel_moves,
  scans_move,
  draws_are_fresh,
  ladder_keeps,
  replicas_travel,
  stones_weigh,
  ascents_weigh,
  levels_walk,
  excursions_keep,
  parts_are_found,
  modes_are_found,
  lineages_are_right,
  excursions_descend,
  results_are_pure,
  rounds_are_frozen,
};

struct Mutant {
  std::string name;
  std::string what;             ///< The mistake, in a sentence.
  std::vector<CheckId> checks;  ///< At least one of these must reject the mutant.
  Lies lies{};
  Step step{};
  sampling::Formulas formulas{};
  std::function<Run()> worker{};  ///< Makes a worker for each run, which may have state.
  std::function<OnTheWay()> way{};
};

inline Mutant right_code() {
  return {.name = "the right code", .what = "nothing", .checks = {}};
}

class MutantWorker final : public plan::UnitWorker {
 public:
  MutantWorker(const Mutant& mutant, const plan::UnitWorker& right)
      : right_(right), run_(mutant.worker ? mutant.worker() : Run{}) {}
  plan::UnitResult run(const plan::Unit& unit, base::BytesView state) const override {
    return run_ ? run_(right_, unit, state) : right_.run(unit, state);
  }

 private:
  const plan::UnitWorker& right_;
  Run run_;
};

class MutantPlan final : public plan::Plan {
 public:
  MutantPlan(const Mutant& mutant, plan::Plan& right)
      : right_(right), way_(mutant.way ? mutant.way() : OnTheWay{}) {}
  std::optional<plan::Unit> next_unit(std::uint32_t scans_max) override {
    std::optional<plan::Unit> unit = right_.next_unit(scans_max);
    if (unit && way_.handed_out) way_.handed_out(*unit);
    return unit;
  }
  void consume(plan::ReplicaKey replica, base::ScanIndex first_scan,
               std::span<const plan::ScanRecord> records) override {
    std::vector<plan::ScanRecord> changed(records.begin(), records.end());
    if (way_.taken_in) way_.taken_in(replica, changed);
    right_.consume(replica, first_scan, changed);
  }
  bool finished() const override { return right_.finished(); }
  std::uint64_t scans_common() const override { return right_.scans_common(); }
  std::uint64_t solutions_found() const override { return right_.solutions_found(); }
  std::vector<plan::Solution> solutions_between(std::uint64_t after,
                                                std::uint64_t until) const override {
    return right_.solutions_between(after, until);
  }
  std::optional<std::uint64_t> solutions_wanted() const override {
    return right_.solutions_wanted();
  }
  std::uint64_t scans_consumed() const override { return right_.scans_consumed(); }
  std::optional<std::uint64_t> scans_total() const override { return right_.scans_total(); }

 private:
  plan::Plan& right_;
  OnTheWay way_;
};

/// The ladder of checks that compare results with enumeration.
inline const std::vector<double>& ladder_of_checks() {
  static const std::vector<double> ladder{0, 0.15, 0.5, 1};
  return ladder;
}

inline double zero_for_log_zero(double l) {
  return std::isinf(l) ? 0 : l;
}

std::vector<Mutant> wrong_kernels();
std::vector<Mutant> wrong_methods();
std::vector<Mutant> wrong_workers();

}  // namespace sleight::statistical
