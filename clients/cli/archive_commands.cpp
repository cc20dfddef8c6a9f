#include "clients/cli/archive_commands.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iostream>
#include <optional>
#include <vector>

#include "clients/analysis/archive_odds.h"
#include "clients/analysis/archive_rows.h"
#include "clients/analysis/failure_counts.h"
#include "clients/analysis/sampling_method.h"
#include "clients/terminal/dumped_json.h"
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
  std::uint64_t count = 0;  ///< of what is there: NaN stands for nothing
  double mean() const { return value / static_cast<double>(count); }
};

/// Over a whole dataset of /sample_stats, without holding it.
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

/// How plausible finds are by themselves: log p_w of the kept ones, and of blind throws the middle
/// nine tenths.
struct Plausibility {
  double least = 0;
  double most = 0;
  double throws_from = 0;
  double throws_to = 0;
};

/// The numbers of a dataset of /finds but NaNs, which a damaged file may have.
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
  bool has_one_lineage = false;  ///< of each chain, whose method has no way to another one
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

/// "9 kept (at most 3 of each of 4 chains)": the rule that bounds their number first.
std::string kept_animations(const Facts& facts) {
  const archive::Summary& summary = facts.summary;
  if (summary.keep_max <= 0) return "none kept (keep_max is 0)";
  if (summary.keep_per_lineage <= 0) return "none kept (keep_per_lineage is 0)";
  const auto most = static_cast<std::uint64_t>(summary.keep_max);
  const auto each = static_cast<std::uint64_t>(summary.keep_per_lineage);
  if (facts.has_one_lineage && summary.chains > 0 && each <= most / summary.chains) {
    return fmt::format("{} kept (at most {} of each of {} chains)", summary.animations, each,
                       summary.chains);
  }
  if (facts.has_one_lineage)
    return fmt::format("{} kept (at most {} in all)", summary.animations, most);
  return fmt::format("{} kept (at most {} of each lineage, {} in all)", summary.animations, each,
                     most);
}

void print_chains(const Facts& facts) {
  const archive::Summary& summary = facts.summary;
  fmt::print("  chains       {}\n", summary.chains);
  fmt::print("  scans        {} of each chain\n", summary.scans);
  fmt::print("  states       {} of each chain ({})\n", summary.states,
             summary.thin == 1 ? "every scan" : fmt::format("every {} scans", summary.thin));
  fmt::print("  satisfied    {:.1f}% of scans\n", 100 * facts.satisfied);
  fmt::print("  accepted     {:.1f}% of proposals\n", 100 * facts.acceptance);
  fmt::print("  animations   {}, {} segments of motion\n", kept_animations(facts),
             summary.segments);
}

void print_finds(const Facts& facts) {
  const archive::FindsSummary& finds = facts.summary.finds;
  if (finds.found == 0) return;
  fmt::print("  {} {}, not in the model's proportions; {} kept, {} segments of motion\n",
             finds.relax_scans > 0 ? "takes       " : "found       ", finds.found, finds.animations,
             finds.segments);
  if (finds.relax_scans > 0)
    fmt::print("               each relaxed by {} scans of a chain\n", finds.relax_scans);
  if (!facts.finds) return;
  const Plausibility& log_p = *facts.finds;
  fmt::print(
      "               log p {:.1f} to {:.1f}; of blind throws nine in ten have {:.1f} to "
      "{:.1f}\n",
      log_p.least, log_p.most, log_p.throws_from, log_p.throws_to);
}

void print_for_people(const std::string& path, const Facts& facts) {
  const archive::Summary& summary = facts.summary;
  fmt::print("{}: {} samples\n\n", path, summary.world);
  if (!summary.warning.empty()) fmt::print("  warning      {}\n", summary.warning);
  if (summary.scans > 0) print_chains(facts);
  print_finds(facts);
  if (summary.failures.total() > 0)
    fmt::print("  failed       {} simulations, refused: {}\n", summary.failures.total(),
               plan::to_string(summary.failures));
  if (summary.failed_animations > 0)
    fmt::print("               {} satisfied, but could not be simulated to rest: not kept\n",
               summary.failed_animations);
  if (facts.odds) fmt::print("{}", in_words(*facts.odds));
  fmt::print("  written by   sleight {}, format {}\n", summary.inference_library_version,
             summary.format_version);
  fmt::print("  run          {}, results {}\n", summary.run_id, summary.results_version);
  fmt::print("  digest       {}\n\n", summary.content_digest);
  fmt::print("The request that reproduces it:\n\n{}", summary.request_text);
}

json::Value as_json(const std::string& path, const Facts& facts) {
  const archive::Summary& summary = facts.summary;
  json::Value json{{"archive", path},
                   {"world", summary.world},
                   {"format_version", summary.format_version},
                   {"warning", summary.warning},
                   {"chains", summary.chains},
                   {"scans", summary.scans},
                   {"states", summary.states},
                   {"thin", summary.thin},
                   {"satisfied_share", facts.satisfied},
                   {"acceptance_rate", facts.acceptance},
                   {"animations", summary.animations},
                   {"segments", summary.segments},
                   {"found", summary.finds.found},
                   {"relax_scans", summary.finds.relax_scans},
                   {"finds_kept", summary.finds.animations},
                   {"failed_simulations", analysis::failures_json(summary.failures)},
                   {"failed_animations", summary.failed_animations},
                   {"version", summary.inference_library_version},
                   {"results_version", summary.results_version},
                   {"run_id", summary.run_id},
                   {"digest", summary.content_digest},
                   {"request", summary.request_text}};
  if (facts.finds) {
    const Plausibility& log_p = *facts.finds;
    json["log_prior_of_finds"] = {log_p.least, log_p.most};
    json["log_prior_of_throws"] = {log_p.throws_from, log_p.throws_to};
  }
  if (facts.odds) json["tempering"] = as_json(*facts.odds);
  return json;
}

}  // namespace

int archive_info(const std::string& path, bool json) {
  const Facts facts = facts_of(*archive::remote::open_remote(path));
  if (json) {
    fmt::print("{}\n", terminal::dumped(as_json(path, facts)));
  } else {
    print_for_people(path, facts);
  }
  return terminal::k_ok;
}

int archive_digest(const std::string& path, bool json) {
  const std::string digest = archive::digest(*archive::remote::open_remote(path));
  if (json) {
    fmt::print("{}\n", terminal::dumped({{"archive", path}, {"digest", digest}}));
  } else {
    fmt::print("{}\n", digest);
  }
  return terminal::k_ok;
}

int archive_verify(const std::string& path, bool json) {
  const std::vector<std::string> findings = archive::verify(*archive::remote::open_remote(path));
  if (json) {
    fmt::print("{}\n", terminal::dumped(
                           {{"archive", path}, {"ok", findings.empty()}, {"findings", findings}}));
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

}  // namespace sleight::cli
