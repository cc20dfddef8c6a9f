#include "clients/analysis/run_counts.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "clients/analysis/after_burn_in.h"
#include "clients/analysis/archive_rows.h"
#include "clients/analysis/request_numbers.h"
#include "clients/analysis/sampling_method.h"
#include "common/archive/format.h"
#include "common/base/error.h"

namespace sleight::analysis {
namespace {

/// Throws if a dataset of /sample_stats has an unexpected type or dimensions.
void check_shape(const archive::Source& source, std::string_view name, archive::ElementType type,
                 const std::vector<std::uint64_t>& sizes) {
  const archive::Group* stats = archive::find_group(source, archive::k_sample_stats);
  const archive::DatasetSpec* spec = stats == nullptr ? nullptr : find_dataset(*stats, name);
  if (spec == nullptr || spec->type != type ||
      !std::ranges::equal(spec->dims, sizes, {}, &archive::Dimension::size)) {
    throw base::Error(base::ExitCode::bad_archive,
                      fmt::format("{}: {} is missing or has an unexpected shape", source.name(),
                                  archive::path_of(archive::k_sample_stats, name)));
  }
}

void make_distinct(std::vector<std::int64_t>& values) {
  std::ranges::sort(values);
  const auto rest = std::ranges::unique(values);
  values.erase(rest.begin(), rest.end());
}

/// Counts distinct lineages of a chain's satisfied scans, in bounded memory.
class Lineages {
 public:
  void add(std::int64_t lineage) {
    if (more_ || (!seen_.empty() && seen_.back() == lineage)) return;
    seen_.push_back(lineage);
    if (seen_.size() < 2 * k_lineages_max) return;
    make_distinct(seen_);
    more_ = seen_.size() > k_lineages_max;
  }
  std::uint64_t count() {
    make_distinct(seen_);
    return seen_.size();
  }
  bool more() const { return more_; }

 private:
  std::vector<std::int64_t> seen_;
  bool more_ = false;
};

/// Returns a ladder's number of simulations. `starts`: scans in which each level simulates one new
/// draw.
double on_ladder(double levels, double scans, double starts, double each) {
  return starts * levels + (scans - starts) * (1 + each * (levels - 1));
}

double by_ladders(const archive::Source& source, const RunSizes& sizes, double each) {
  double sum = 0;
  for (std::size_t r = 0; r < sizes.rounds.size(); ++r) {
    const auto first = static_cast<double>(sizes.rounds[r].first_scan);
    const auto scans = static_cast<double>(sizes.rounds[r].scans);
    for (const double levels : of_ladders(source, "levels", sizes.chains, r)) {
      // Annealing scans precede the first round and include the starts.
      if (r == 0 && first > 0) sum += on_ladder(levels, first, 1, each);
      sum += on_ladder(levels, scans, first == 0 ? 1 : 0, each);
    }
  }
  return sum;
}

/// Simulations after a burn-in.
double by_chains(const archive::Source& source, const RunSizes& sizes, double each) {
  const auto draws = static_cast<double>(sizes.draws);
  double sum = 0;
  if (sizes.method == request::Method::simulated_tempering) {
    for (std::uint64_t c = 0; c < sizes.chains; ++c) {
      const std::vector<double> visits = row_of_chain(source, "walk_visits", "walk_level", c);
      for (std::size_t level = 0; level < visits.size(); ++level)
        sum += std::isnan(visits[level]) ? 0 : visits[level] * (level == 0 ? 1 : each);
    }
  } else if (sizes.method == request::Method::tempered_transitions) {
    // Each excursion goes to the prior and back, and makes one prior draw.
    for (const TransitionReport& chain : transitions_of(source, sizes.chains))
      sum += draws * (each + 2 * each * (chain.levels - 1) + 1);
  } else if (sizes.method == request::Method::annealed_importance) {
    for (const AscentReport& chain : ascents_of(source, sizes.chains))
      sum += draws * (1 + each * (chain.steps - 1));
  }
  return sum;
}

}  // namespace

RunCounts run_counts(const archive::Source& source, const Round& judged) {
  const std::uint64_t chains = stats_size(source, "chain");
  const std::uint64_t scans = stats_size(source, "draw");
  check_shape(source, "satisfied", archive::ElementType::boolean, {chains, scans});
  check_shape(source, "lineage", archive::ElementType::i64, {chains, scans});
  RunCounts counts;
  for (std::uint64_t chain = 0; chain < chains; ++chain) {
    Lineages lineages;
    for (std::uint64_t first = 0; first < scans; first += k_batch) {
      const std::uint64_t count = std::min(k_batch, scans - first);
      const auto read = [&](std::string_view name) {
        return source.read(archive::k_sample_stats, name, chain * scans + first, count);
      };
      const auto satisfied = std::get<std::vector<std::int8_t>>(read("satisfied"));
      const auto lineage = std::get<std::vector<std::int64_t>>(read("lineage"));
      for (std::uint64_t i = 0; i < count; ++i) {
        if (satisfied[i] == 0) continue;
        const std::uint64_t scan = first + i;
        ++counts.satisfied;
        counts.satisfied_judged +=
            scan >= judged.first_scan && scan - judged.first_scan < judged.scans ? 1 : 0;
        lineages.add(lineage[i]);
      }
    }
    counts.solutions += lineages.count();
    counts.solutions_more = counts.solutions_more || lineages.more();
  }
  return counts;
}

std::vector<KindReport> kind_counts(const archive::Source& source, const Round& judged) {
  const std::uint64_t chains = stats_size(source, "chain");
  const std::uint64_t scans = stats_size(source, "draw");
  std::vector<KindReport> reports;
  for (std::string& name : proposal_kinds(source))
    reports.push_back({.name = std::move(name)});
  const std::uint64_t kinds = reports.size();
  if (kinds == 0) return reports;
  const std::uint64_t batch = std::max(k_batch / kinds, std::uint64_t{1});
  const auto add = [&](std::string_view name, std::uint64_t KindReport::*sum) {
    check_shape(source, name, archive::ElementType::i32, {chains, scans, kinds});
    for (std::uint64_t chain = 0; chain < chains; ++chain) {
      for (std::uint64_t done = 0; done < judged.scans; done += batch) {
        const std::uint64_t rows = std::min(batch, judged.scans - done);
        const auto values = std::get<std::vector<std::int32_t>>(
            source.read(archive::k_sample_stats, name,
                        (chain * scans + judged.first_scan + done) * kinds, rows * kinds));
        for (std::size_t i = 0; i < values.size(); ++i)
          reports[i % kinds].*sum += static_cast<std::uint64_t>(std::max(values[i], 0));
      }
    }
  };
  add("proposed", &KindReport::proposed);
  add("accepted", &KindReport::accepted);
  return reports;
}

double simulations_of(const archive::Source& source, const std::string& request_text,
                      const RunSizes& sizes) {
  const RequestNumbers numbers(request_text, source.name());
  const auto each = numbers.find("sampler", "iterations_per_scan");
  if (!each || draws_are_burnt_in(source, sizes.method))
    return std::numeric_limits<double>::quiet_NaN();
  if (sizes.rounds.empty()) {
    const double annealed = numbers.find("sampler", "anneal_scans").value_or(0);
    const double scans = annealed + static_cast<double>(sizes.draws);
    return static_cast<double>(sizes.chains) * (1 + *each * (scans - 1));
  }
  return by_ladders(source, sizes, *each) + by_chains(source, sizes, *each);
}

json::Value failures_json(const plan::FailureCounts& failures) {
  json::Value json{{"total", failures.total()}};
  for (std::size_t kind = 0; kind < plan::k_failure_kinds; ++kind) {
    if (failures.by_kind[kind] > 0)
      json[std::string(plan::k_failure_names[kind])] = failures.by_kind[kind];
  }
  return json;
}

}  // namespace sleight::analysis
