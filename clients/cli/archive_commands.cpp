#include "clients/cli/archive_commands.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iostream>
#include <optional>

#include "clients/analysis/archive_odds.h"
#include "clients/analysis/archive_rows.h"
#include "clients/analysis/diagnosis_report.h"
#include "clients/analysis/run_counts.h"
#include "clients/analysis/sampling_method.h"
#include "clients/report/report.h"
#include "clients/terminal/output.h"
#include "common/archive/csv.h"
#include "common/archive/digest/digest.h"
#include "common/archive/digest/verify.h"
#include "common/archive/format.h"
#include "common/archive/remote/remote_source.h"
#include "common/archive/summary.h"
#include "common/base/error.h"
#include "common/base/output_beside.h"
#include "common/json/value.h"

namespace sleight::cli {
namespace {

constexpr int k_bad_archive = static_cast<int>(base::ExitCode::bad_archive);

struct Sum {
  double value = 0;
  std::uint64_t count = 0;  ///< without NaN, which means no value
  double mean() const { return value / static_cast<double>(count); }
};

/// Adds up a dataset of /sample_stats without holding all of it in memory.
Sum sum_of(const archive::Source& source, std::string_view dataset) {
  const std::uint64_t count = analysis::stats_size(source, dataset);
  Sum sum;
  for (std::uint64_t first = 0; first < count; first += analysis::k_batch) {
    const archive::Values values = source.read(archive::k_sample_stats, dataset, first,
                                               std::min(analysis::k_batch, count - first));
    if (const auto* doubles = std::get_if<std::vector<double>>(&values)) {
      for (const double value : *doubles) {
        if (std::isnan(value)) continue;
        sum.value += value;
        ++sum.count;
      }
    } else if (const auto* flags = std::get_if<std::vector<std::int8_t>>(&values)) {
      for (const std::int8_t value : *flags)
        sum.value += value;
      sum.count += flags->size();
    }
  }
  return sum;
}

/// Ranges of log p_w that show whether finds are plausible: the range of kept finds, and the range
/// of the central 90% of blind throws.
struct Plausibility {
  double least = 0;
  double most = 0;
  double throws_from = 0;
  double throws_to = 0;
};

/// Returns the numbers of a dataset of /finds. Leaves out NaN, which only a damaged file has.
std::vector<double> numbers_of_finds(const archive::Source& source, std::string_view dataset,
                                     std::uint64_t count) {
  std::vector<double> numbers =
      analysis::read_rows(source, archive::k_finds, dataset, 1, {.count = count});
  std::erase_if(numbers, [](double number) { return std::isnan(number); });
  return numbers;
}

std::optional<Plausibility> plausibility_of(const archive::Source& source,
                                            const archive::Summary& summary) {
  if (summary.finds.animations == 0) return std::nullopt;
  const archive::Group* finds = archive::find_group(source, archive::k_finds);
  const archive::DatasetSpec* of_throws = archive::find_dataset(*finds, "log_prior_of_throw");
  if (of_throws == nullptr) return std::nullopt;
  const std::uint64_t count =
      std::min<std::uint64_t>(archive::element_count(*of_throws), archive::k_throws);
  std::vector<double> throws = numbers_of_finds(source, "log_prior_of_throw", count);
  const std::vector<double> found = numbers_of_finds(source, "log_prior", summary.finds.animations);
  if (throws.empty() || found.empty()) return std::nullopt;
  std::ranges::sort(throws);
  const std::size_t twentieth = throws.size() / 20;
  return Plausibility{.least = *std::ranges::min_element(found),
                      .most = *std::ranges::max_element(found),
                      .throws_from = throws[twentieth],
                      .throws_to = throws[throws.size() - 1 - twentieth]};
}

struct Facts {
  archive::Summary summary;
  double satisfied = 0;   ///< share of all scans
  double acceptance = 0;  ///< mean over scans with proposals
  std::optional<analysis::ArchiveOdds> odds{};
  std::optional<Plausibility> finds{};
  bool has_one_lineage = false;  ///< each chain has one: the method never changes the lineage
};

Facts facts_of(const archive::Source& source) {
  Facts facts{.summary = archive::summary_of(source)};
  facts.finds = plausibility_of(source, facts.summary);
  const std::uint64_t scans = facts.summary.chains * facts.summary.scans;
  if (scans == 0) return facts;
  const auto method = analysis::method_of(facts.summary.request_text);
  facts.has_one_lineage = method == request::Method::metropolis_hastings &&
                          !analysis::draws_are_burnt_in(source, method);
  facts.odds = analysis::odds_of(source, facts.summary);
  facts.satisfied = sum_of(source, "satisfied").value / static_cast<double>(scans);
  const Sum acceptance = sum_of(source, "acceptance_rate");
  if (acceptance.count > 0) facts.acceptance = acceptance.mean();
  return facts;
}

/// Returns, for example, "9 kept (at most 3 from each of 4 chains)".
std::string kept_animations(const Facts& facts) {
  const archive::Summary& summary = facts.summary;
  if (summary.keep_max <= 0) return "none kept (keep_max is 0)";
  if (summary.keep_per_lineage <= 0) return "none kept (keep_per_lineage is 0)";
  const auto most = static_cast<std::uint64_t>(summary.keep_max);
  const auto each = static_cast<std::uint64_t>(summary.keep_per_lineage);
  if (facts.has_one_lineage && summary.chains > 0 && each <= most / summary.chains) {
    return fmt::format("{} kept (at most {} from each of {} chains)", summary.animations, each,
                       summary.chains);
  }
  if (facts.has_one_lineage)
    return fmt::format("{} kept (at most {} in total)", summary.animations, most);
  return fmt::format("{} kept (at most {} from each lineage, {} in total)", summary.animations,
                     each, most);
}

void add_chains(const Facts& facts, report::Report& report) {
  const archive::Summary& summary = facts.summary;
  const auto of_each = [](std::uint64_t count) { return fmt::format("{} of each chain", count); };
  const auto where_any = [&](std::string words) { return summary.scans > 0 ? words : ""; };
  report.add("chains", summary.chains, "chains", where_any(fmt::format("{}", summary.chains)));
  report.add("scans", summary.scans, "scans", where_any(of_each(summary.scans)));
  const std::string which =
      summary.thin == 1 ? "every scan" : fmt::format("every {} scans", summary.thin);
  report.add("states", summary.states, "states",
             where_any(fmt::format("{} ({})", of_each(summary.states), which)));
  report.for_programs("thin", summary.thin);
  report.add("satisfied_share", facts.satisfied, "satisfied",
             where_any(fmt::format("{:.1f}% of scans", 100 * facts.satisfied)));
  report.add("acceptance_rate", facts.acceptance, "accepted",
             where_any(fmt::format("{:.1f}% of proposals", 100 * facts.acceptance)));
  report.add("animations", summary.animations, "animations",
             where_any(fmt::format("{}, {} segments of motion", kept_animations(facts),
                                   summary.segments)));
  report.for_programs("segments", summary.segments);
}

void add_finds(const Facts& facts, report::Report& report) {
  const archive::FindsSummary& finds = facts.summary.finds;
  report.add("found", finds.found, finds.relax_scans > 0 ? "takes" : "found",
             finds.found == 0
                 ? ""
                 : fmt::format("{}, not in the model's proportions; {} kept, {} segments of motion",
                               finds.found, finds.animations, finds.segments));
  report.add("relax_scans", finds.relax_scans, "",
             finds.found == 0 || finds.relax_scans == 0
                 ? ""
                 : fmt::format("a chain of {} scans relaxed each take", finds.relax_scans));
  report.for_programs("finds_kept", finds.animations);
  if (!facts.finds) return;
  const Plausibility& log_p = *facts.finds;
  report.add("log_prior_of_finds", {log_p.least, log_p.most}, "",
             fmt::format("log p {:.1f} to {:.1f} (90% of blind throws: {:.1f} to {:.1f})",
                         log_p.least, log_p.most, log_p.throws_from, log_p.throws_to));
  report.for_programs("log_prior_of_throws", {log_p.throws_from, log_p.throws_to});
}

void add_failures(const archive::Summary& summary, report::Report& report) {
  const std::uint64_t failed = summary.failures.total();
  report.add("failed_simulations", analysis::failures_json(summary.failures), "failed",
             failed == 0 ? ""
                         : fmt::format("{} simulations, all rejected: {}", failed,
                                       plan::to_string(summary.failures)));
  report.add("failed_animations", summary.failed_animations, "",
             summary.failed_animations == 0
                 ? ""
                 : fmt::format("{} animations that satisfy the constraint were not stored, because "
                               "the simulator could not complete their motion",
                               summary.failed_animations));
}

report::Report report_of(const std::string& path, const Facts& facts) {
  const archive::Summary& summary = facts.summary;
  report::Report report;
  report.for_programs("archive", path);
  report.for_programs("world", summary.world);
  report.add("warning", summary.warning, "warning", summary.warning);
  add_chains(facts, report);
  add_finds(facts, report);
  add_failures(summary, report);
  if (facts.odds) add_odds(*facts.odds, report);
  report.add("version", summary.inference_library_version, "written by",
             fmt::format("sleight {}, format {}", summary.inference_library_version,
                         summary.format_version));
  report.for_programs("format_version", summary.format_version);
  report.add("run_id", summary.run_id, "run",
             fmt::format("{}, results {}", summary.run_id, summary.results_version));
  report.for_programs("results_version", summary.results_version);
  report.add("digest", summary.content_digest, "digest", summary.content_digest);
  report.for_programs("request", summary.request_text);
  return report;
}

}  // namespace

int archive_info(const std::string& path, bool json) {
  const Facts facts = facts_of(*archive::remote::open_remote(path));
  const report::Report report = report_of(path, facts);
  if (json) {
    fmt::print("{}\n", report.as_json().dump(2));
  } else {
    fmt::print(
        "{}: {} samples\n\n"
        "{}\n"
        "The request that reproduces this archive:\n\n"
        "{}",
        path, facts.summary.world, report.as_text(2, 13), facts.summary.request_text);
  }
  return terminal::k_ok;
}

int archive_digest(const std::string& path, bool json) {
  const std::string digest = archive::digest(*archive::remote::open_remote(path));
  if (json) {
    fmt::print("{}\n", json::Value{{"archive", path}, {"digest", digest}}.dump(2));
  } else {
    fmt::print("{}\n", digest);
  }
  return terminal::k_ok;
}

int archive_verify(const std::string& path, bool json) {
  const std::vector<std::string> findings = archive::verify(*archive::remote::open_remote(path));
  if (json) {
    fmt::print(
        "{}\n",
        json::Value{{"archive", path}, {"ok", findings.empty()}, {"findings", findings}}.dump(2));
  } else {
    for (const std::string& finding : findings)
      fmt::print("{}: {}\n", path, finding);
    if (findings.empty()) fmt::print("{}: ok\n", path);
  }
  return findings.empty() ? terminal::k_ok : k_bad_archive;
}

int archive_export_csv(const ExportOptions& options) {
  if (options.output.empty() || options.output == "-") {
    archive::export_csv(*archive::remote::open_remote(options.path), options.table, std::cout,
                        options.animations);
    return terminal::k_ok;
  }
  terminal::refuse_same_file(options.path, options.output);
  const auto source = archive::remote::open_remote(options.path);
  base::write_output(options.output, [&](std::ostream& file) {
    archive::export_csv(*source, options.table, file, options.animations);
  });
  return terminal::k_ok;
}

int diagnose_archive(const std::string& path, bool json, const analysis::Rules& rules) {
  const analysis::Diagnosis diagnosis = diagnosis_of(*archive::remote::open_remote(path), rules);
  if (json) {
    fmt::print("{}\n", as_json(path, diagnosis).dump(2));
  } else {
    fmt::print("{}", for_people(path, diagnosis));
  }
  return static_cast<int>(diagnosis.mixed() ? base::ExitCode::ok : base::ExitCode::not_mixed);
}

}  // namespace sleight::cli
