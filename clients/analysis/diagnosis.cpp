#include "clients/analysis/diagnosis.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include "clients/analysis/archive_rows.h"
#include "clients/analysis/odds_doubts.h"
#include "clients/analysis/run_counts.h"
#include "clients/analysis/sampling_method.h"
#include "common/archive/format.h"
#include "common/base/error.h"

namespace sleight::analysis {
namespace {

/// Maximum ladders that are judged level by level.
constexpr std::uint64_t k_ladders_max = 64;

struct Sizes {
  std::uint64_t chains = 0;
  std::uint64_t scalars = 0;
};

struct Judged {
  const archive::Source& source;
  const Rules& rules;
  Diagnosis& diagnosis;
};

/// Returns mean and standard deviation of the finite values. The standard deviation of a single
/// value is NaN.
std::pair<double, double> moments_of_finite(std::span<const double> values) {
  double sum = 0;
  double count = 0;
  for (const double value : values) {
    sum += std::isfinite(value) ? value : 0;
    count += std::isfinite(value) ? 1 : 0;
  }
  const double mean = count > 0 ? sum / count : k_not_known;
  double squares = 0;
  for (const double value : values)
    squares += std::isfinite(value) ? (value - mean) * (value - mean) : 0;
  return {mean, count > 1 ? std::sqrt(squares / (count - 1)) : k_not_known};
}

ScalarReport report_of(const Rules& rules, std::string name, const DrawRange& range,
                       std::vector<double>& values) {
  ScalarReport report{.name = std::move(name), .verdict = {}, .not_finite = {}};
  const auto [mean, sd] = moments_of_finite(values);
  report.not_finite = with_stand_in(values);
  report.verdict =
      rules.judge(report.name, {.values = values, .chains = range.chains, .draws = range.count});
  if (report.not_finite.all() > 0) {
    report.verdict.mean = mean;
    report.verdict.sd = sd;
    report.verdict.mcse = k_not_known;
  }
  // complain_of_few() reports too few draws, once for all scalars.
  if (range.count < rules.draws_min) report.verdict.complaints.clear();
  return report;
}

/// Orders the worst scalars first: by complaints, then by R-hat, then by effective sample size.
bool is_worse(const ScalarReport& a, const ScalarReport& b) {
  const auto key = [](const ScalarReport& report) {
    const Verdict& v = report.verdict;
    const double r_hat = std::isnan(v.r_hat) ? 0 : v.r_hat;
    const double ess = std::isnan(v.ess_bulk) ? std::numeric_limits<double>::max() : v.ess_bulk;
    return std::tuple(v.complaints.empty(), -r_hat, ess);
  };
  return key(a) < key(b);
}

/// Complains if any draw has probability 0. Only for log densities.
void complain_of_zero_density(ScalarReport& report, std::uint64_t draws) {
  const std::uint64_t count = report.not_finite.minus_infinite;
  if (count == 0) return;
  report.verdict.complaints.insert(
      report.verdict.complaints.begin(),
      fmt::format("{}: {} of {} draws are -inf (probability 0), so a chain has not yet reached a "
                  "state that the request allows",
                  report.name, count, draws));
}

void note_thinning(Judged& judged, const DrawRange& range, std::string_view what) {
  if (range.stride == 1) return;
  judged.diagnosis.notes.push_back(fmt::format(
      "{}: only one of every {} draws was used, so the effective sample sizes refer to {} "
      "draws per chain",
      what, range.stride, range.count));
}

/// Reports too few draws once, for all scalars together. `what`: such as "judged scans".
void complain_of_few(Judged& judged, const DrawRange& range, std::string_view what) {
  const double wanted = judged.rules.ess_wanted(range.chains);
  if (range.count < judged.rules.draws_min) {
    judged.diagnosis.reasons.push_back(
        fmt::format("each chain has too few {}: {}, but at least {} are needed", what, range.count,
                    judged.rules.draws_min));
  } else if (static_cast<double>(range.chains * range.count) < wanted) {
    judged.diagnosis.reasons.push_back(
        fmt::format("each chain has too few {}: {}; even if all were independent, the effective "
                    "sample size would be below {:.0f}",
                    what, range.count, wanted));
  }
}

void judge_scalars(Judged& judged, const DrawRange& range) {
  std::vector<std::string> names{"lp", "log_constraint"};
  std::ranges::copy(outcome_names(judged.source), std::back_inserter(names));
  complain_of_few(judged, range, "judged scans");
  note_thinning(judged, range, "lp, log_constraint and outcomes");
  for (const std::string& name : names) {
    for_each_scalar(judged.source, {.group = archive::k_sample_stats, .name = name}, 1, range,
                    [&](std::uint64_t, std::vector<double>& values) {
                      ScalarReport report = report_of(judged.rules, name, range, values);
                      if (name == "log_constraint") {
                        complain_of_zero_density(report, range.chains * range.count);
                      }
                      judged.diagnosis.scalars.push_back(std::move(report));
                    });
    std::ranges::copy(judged.diagnosis.scalars.back().verdict.complaints,
                      std::back_inserter(judged.diagnosis.reasons));
  }
}

VariableReport variable_report(const Judged& judged, const Quantity& variable,
                               std::uint64_t entries, const DrawRange& range) {
  VariableReport report{.name = variable.name, .entries = variable.entries(), .judged = entries};
  const bool all = report.entries <= k_entries_listed_max;
  for_each_scalar(
      judged.source, variable, entries, range,
      [&](std::uint64_t entry, std::vector<double>& values) {
        report.listed.push_back(report_of(judged.rules, variable.entry_name(entry), range, values));
        report.failing += report.listed.back().verdict.complaints.empty() ? 0 : 1;
        if (all || report.listed.size() <= k_entries_listed_max) return;
        std::ranges::stable_sort(report.listed, is_worse);
        report.listed.pop_back();
      });
  if (!all) std::ranges::stable_sort(report.listed, is_worse);
  return report;
}

/// Adds only the reason of the variable's worst entry. More reasons would hide the other variables'
/// reasons.
void complain_of_variable(Judged& judged, const VariableReport& report) {
  if (report.failing == 0) return;
  const ScalarReport& worst = *std::ranges::min_element(report.listed, is_worse);
  std::string reason = worst.verdict.complaints.front();
  if (report.failing > 1) {
    reason += fmt::format(" (and {} more of {} entries)", report.failing - 1, report.judged);
  }
  judged.diagnosis.reasons.push_back(std::move(reason));
}

void judge_variables(Judged& judged, const std::vector<Quantity>& variables,
                     const DrawRange& range) {
  if (variables.empty()) return;
  // If every scan's state is archived, judge_scalars() has already complained if there are too few.
  if (judged.diagnosis.states < judged.diagnosis.judged.scans) {
    complain_of_few(judged, range,
                    "archived states (see the request's key `thin`) in the judged scans");
  }
  note_thinning(judged, range, "state variables");
  std::uint64_t left = scalars_max(range);
  for (const Quantity& variable : variables) {
    const std::uint64_t entries = std::min(variable.entries(), left);
    left -= entries;
    if (entries < variable.entries()) {
      judged.diagnosis.notes.push_back(
          fmt::format("{}: skipped {} of {} entries, because there are too many", variable.name,
                      variable.entries() - entries, variable.entries()));
    }
    judged.diagnosis.variables.push_back(variable_report(judged, variable, entries, range));
    complain_of_variable(judged, judged.diagnosis.variables.back());
  }
}

/// Judges whether each ladder's states made a round trip in the judged round. A burn-in's ladders
/// are only shown, because no draw depends on their trips.
void judge_ladders(Judged& judged, std::uint64_t chains, std::span<const Round> rounds,
                   bool burn_in) {
  const std::size_t round = judged_round(rounds);
  TemperingReport report{
      .round = round + 1, .rounds = rounds.size(), .burn_in = burn_in, .ladders = {}};
  const auto numbers = [&](std::string_view name) {
    return of_ladders(judged.source, name, chains, round);
  };
  const std::vector<double> barriers = numbers("barrier");
  const std::vector<double> trips = numbers("round_trips");
  const std::vector<double> restarts = numbers("restarts");
  const std::vector<double> rates = numbers("predicted_round_trip_rate");
  const std::vector<std::uint64_t> none = without_round_trip(judged.source, chains, round);
  for (std::uint64_t c = 0; c < std::min<std::uint64_t>(chains, k_ladders_max); ++c) {
    report.ladders.push_back(
        {.barrier = barriers[c],
         .round_trips = trips[c],
         .predicted_round_trips = rates[c] * static_cast<double>(rounds[round].scans),
         .restarts = restarts[c],
         .levels = ladder_of(judged.source, c, round)});
  }
  if (chains > k_ladders_max) {
    judged.diagnosis.notes.push_back(
        fmt::format("only the first {} of {} ladders are shown", k_ladders_max, chains));
  }
  if (!none.empty() && !burn_in) {
    judged.diagnosis.reasons.push_back(fmt::format(
        "{} of {} ladders made no round trip in the judged round{}", none.size(), chains,
        none.size() == chains ? "" : fmt::format(", for example ladder {}", none.front())));
  }
  judged.diagnosis.tempering = std::move(report);
}

/// Judges whether each chain of simulated tempering travelled to the prior and back.
void judge_walks(Judged& judged, std::uint64_t chains) {
  judged.diagnosis.walks = walks_of(judged.source, std::min(chains, k_ladders_max));
  std::vector<std::uint64_t> none;
  const std::vector<double> trips = of_chains(judged.source, "walk_round_trips", chains);
  for (std::uint64_t c = 0; c < chains; ++c) {
    if (!(trips[c] >= 1)) none.push_back(c);
  }
  if (none.empty()) return;
  judged.diagnosis.reasons.push_back(fmt::format(
      "{} of {} chains made no round trip to the prior and back{}", none.size(), chains,
      none.size() == chains ? "" : fmt::format(", for example chain {}", none.front())));
}

void judge_weights(Judged& judged, std::uint64_t chains) {
  WeightsReport report{.effective_size = effective_size_of_all(judged.source),
                       .log_z = {},
                       .log_p_satisfied = {},
                       .chains = ascents_of(judged.source, chains)};
  std::vector<LogEstimate> log_z;
  std::vector<LogEstimate> log_p;
  for (const AscentReport& chain : report.chains) {
    log_z.push_back(chain.log_z);
    log_p.push_back(chain.log_p_satisfied);
  }
  const auto together = [&](std::span<const LogEstimate> chains_say) {
    CombinedEstimate all = combined(chains_say);
    const bool trusted =
        doubts_of_weights(chains_say, report.effective_size, k_effective_size_min).empty();
    if (!trusted) all.log.error = std::numeric_limits<double>::quiet_NaN();
    return all;
  };
  report.log_z = together(log_z);
  report.log_p_satisfied = together(log_p);
  if (!(report.effective_size >= k_effective_size_min)) {
    judged.diagnosis.reasons.push_back(fmt::format(
        "the weighted draws of all chains have effective size {}, but at least {:.0f} is needed; "
        "run more scans, or set a higher steps_per_level or iterations_per_scan, so that the "
        "weights differ less",
        std::isnan(report.effective_size) ? "unknown"
                                          : fmt::format("{:.1f}", report.effective_size),
        k_effective_size_min));
  }
  judged.diagnosis.weights = std::move(report);
}

/// Reports that mixing can't be judged: if tours are too short, their draws agree anyway.
void refuse_tours(Diagnosis& diagnosis, std::int64_t tour_scans) {
  diagnosis.reasons.insert(
      diagnosis.reasons.begin(),
      fmt::format(
          "each draw is the last scan of its own tour of {} scans, so draws are independent, but "
          "their means are wrong if tours are too short; rerun with longer tours to check that the "
          "means stay the same",
          tour_scans));
}

/// `draws_are_burnt_in`: see sampling_method.h.
void choose_scans(Diagnosis& diagnosis, std::optional<request::Method> method,
                  std::span<const Round> rounds, bool draws_are_burnt_in) {
  diagnosis.judged = {.first_scan = 0, .scans = diagnosis.scans};
  if (draws_are_burnt_in) {
    diagnosis.which = JudgedDraws::all;
  } else if (burns_in(method)) {
    const bool weighted = method == request::Method::annealed_importance;
    diagnosis.which = weighted ? JudgedDraws::weighted : JudgedDraws::all;
  } else if (!rounds.empty()) {
    diagnosis.judged = draws_of_round(rounds, judged_round(rounds));
    diagnosis.which = JudgedDraws::round;
  } else {
    diagnosis.judged.first_scan = diagnosis.scans / 2;
    diagnosis.judged.scans = diagnosis.scans - diagnosis.judged.first_scan;
  }
}

/// Returns the index of the first archived state at or after this scan; `states` if there is none.
std::uint64_t first_state_from(const archive::Source& source, std::uint64_t states,
                               std::uint64_t scan) {
  // States are ordered by scan, so use bisection.
  std::uint64_t low = 0;
  std::uint64_t high = states;
  while (low < high) {
    const std::uint64_t middle = low + (high - low) / 2;
    const archive::Values value = source.read(archive::k_posterior, "draw", middle, 1);
    const auto* draws = std::get_if<std::vector<std::int64_t>>(&value);
    if (draws == nullptr || draws->at(0) < 0) {
      throw base::Error(base::ExitCode::bad_archive,
                        source.name() + ": /posterior/draw: expected scan numbers");
    }
    if (static_cast<std::uint64_t>(draws->at(0)) < scan) {
      low = middle + 1;
    } else {
      high = middle;
    }
  }
  return low;
}

/// Returns the archived states of judged scans, in each chain.
DrawRange states_in(const archive::Source& source, const Diagnosis& diagnosis, std::uint64_t states,
                    const Sizes& sizes) {
  const Round& judged = diagnosis.judged;
  const std::uint64_t first = first_state_from(source, states, judged.first_scan);
  const std::uint64_t end = first_state_from(source, states, judged.first_scan + judged.scans);
  return bounded_range(sizes.chains, first, end > first ? end - first : 0, sizes.scalars);
}

void note_chains(Diagnosis& diagnosis, std::uint64_t looked_at) {
  if (looked_at < diagnosis.chains) {
    diagnosis.notes.push_back(
        fmt::format("only the first {} of {} chains are judged", looked_at, diagnosis.chains));
  }
  if (looked_at == 1) {
    diagnosis.notes.emplace_back(
        "there is only one chain, so R-hat compares its two halves; only several chains can reveal "
        "a mode that a chain missed");
  }
}

void judge_draws(Judged& judged, const archive::Summary& summary) {
  Diagnosis& diagnosis = judged.diagnosis;
  const std::uint64_t chains = std::min(summary.chains, k_chains_max);
  note_chains(diagnosis, chains);
  const std::vector<Quantity> variables = state_variables(judged.source);
  std::uint64_t scalars = 2 + outcome_names(judged.source).size();
  for (const Quantity& variable : variables)
    scalars += variable.entries();
  judge_scalars(
      judged, bounded_range(chains, diagnosis.judged.first_scan, diagnosis.judged.scans, scalars));
  const DrawRange states = states_in(judged.source, diagnosis, summary.states, {chains, scalars});
  diagnosis.states = states.count;
  judge_variables(judged, variables, states);
}

}  // namespace

std::string why_not_diagnosed(const archive::Source& source, const archive::Summary& summary) {
  if (summary.finds.found > 0 && summary.scans == 0) {
    return fmt::format("the {} animations come from a search and are not draws",
                       summary.finds.found);
  }
  const archive::Group* learnt = archive::find_group(source, archive::k_tempering);
  const bool has_weights = learnt != nullptr && find_dataset(*learnt, "log_weight") != nullptr;
  const auto method = method_of(summary.request_text);
  if (has_weights && method && request::makes_islands(*method))
    return "the draws come from islands and are therefore independent and weighted; for the odds, "
           "run "
           "`sleight archive info`";
  return {};
}

Diagnosis diagnosis_of(const archive::Source& source, const Rules& rules) {
  const archive::Summary summary = archive::summary_of(source);
  if (const std::string reason = why_not_diagnosed(source, summary); !reason.empty()) {
    throw base::Error(base::ExitCode::usage,
                      fmt::format("{}: nothing to diagnose: {}", source.name(), reason));
  }
  if (summary.chains == 0 || summary.scans == 0) {
    throw base::Error(base::ExitCode::bad_archive, source.name() + ": the archive has no scans");
  }
  Diagnosis diagnosis;
  diagnosis.world = summary.world;
  diagnosis.warning = summary.warning;
  diagnosis.chains = summary.chains;
  diagnosis.scans = summary.scans;
  const std::optional<request::Method> method = method_of(summary.request_text);
  const std::vector<Round> rounds =
      rounds_of(source, summary.chains,
                burns_in(method) ? std::nullopt : std::optional<std::uint64_t>(summary.scans));
  choose_scans(diagnosis, method, rounds, draws_are_burnt_in(source, method));
  const std::optional<std::int64_t> tour_scans = tour_scans_of(summary.request_text);
  if (tour_scans) diagnosis.which = JudgedDraws::tours;
  Judged judged{.source = source, .rules = rules, .diagnosis = diagnosis};
  if (diagnosis.which == JudgedDraws::weighted) {
    judge_weights(judged, summary.chains);
  } else {
    judge_draws(judged, summary);
  }
  if (tour_scans) refuse_tours(diagnosis, *tour_scans);
  if (!rounds.empty()) judge_ladders(judged, summary.chains, rounds, burns_in(method));
  if (method == request::Method::simulated_tempering) judge_walks(judged, summary.chains);
  if (method == request::Method::tempered_transitions)
    diagnosis.transitions = transitions_of(source, std::min(summary.chains, k_ladders_max));

  const RunCounts counts = run_counts(source, diagnosis.judged);
  diagnosis.satisfied = counts.satisfied;
  diagnosis.satisfied_judged = counts.satisfied_judged;
  diagnosis.solutions = counts.solutions;
  diagnosis.solutions_more = counts.solutions_more;
  diagnosis.kinds = kind_counts(source, diagnosis.judged);
  diagnosis.simulations = simulations_of(
      source, summary.request_text,
      {.method = method, .chains = summary.chains, .draws = summary.scans, .rounds = rounds});
  return diagnosis;
}

}  // namespace sleight::analysis
