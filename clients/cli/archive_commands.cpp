#include "clients/cli/archive_commands.h"

#include <fmt/format.h>

#include <cerrno>
#include <cmath>
#include <cstring>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>
#include <optional>
#include <vector>

#include "clients/cli/after_burn_in.h"
#include "clients/cli/opened_archive.h"
#include "clients/cli/output.h"
#include "clients/cli/sampling_method.h"
#include "clients/cli/tempering.h"
#include "clients/cli/throw_odds.h"
#include "clients/cli/trace.h"
#include "common/archive/csv.h"
#include "common/archive/digest/digest.h"
#include "common/archive/digest/verify.h"
#include "common/archive/format.h"
#include "common/archive/summary.h"
#include "common/base/error.h"

namespace sleight::cli {
namespace {

constexpr int k_ok = static_cast<int>(base::ExitCode::ok);
constexpr int k_bad_archive = static_cast<int>(base::ExitCode::bad_archive);

/// Scans read at a time for statistics over the whole run.
constexpr std::uint64_t k_batch = 65536;

/// Sum over a whole dataset of /sample_stats without holding it.
double sum_of(const archive::Source& source, std::string_view dataset) {
  const std::uint64_t count = stats_size(source, dataset);
  double sum = 0;
  for (std::uint64_t first = 0; first < count; first += k_batch) {
    const archive::Values values =
        source.read(archive::k_sample_stats, dataset, first, std::min(k_batch, count - first));
    if (const auto* doubles = std::get_if<std::vector<double>>(&values)) {
      for (const double value : *doubles)
        sum += std::isnan(value) ? 0 : value;
    } else if (const auto* flags = std::get_if<std::vector<std::int8_t>>(&values)) {
      for (const std::int8_t value : *flags)
        sum += value;
    }
  }
  return sum;
}

/// What the ladders of a tempered run estimate, or its weighted ascents.
struct Tempered {
  bool weighted = false;  ///< of the ascents: then no round is told
  bool burn_in = false;   ///< the rounds are a burn-in's
  std::size_t rounds = 0;
  std::size_t judged = 0;  ///< the round that log_z is of
  CombinedEstimate log_z;
  std::size_t satisfied_round = 0;   ///< the round that log_p_satisfied is of
  CombinedEstimate log_p_satisfied;  ///< of no ladder: nothing ever satisfied
  std::size_t without_trips = 0;     ///< ladders of that round that made no round trip
  double log_natural_throw = 0;
};

struct Facts {
  archive::Summary summary;
  double satisfied = 0;   ///< share of all scans
  double acceptance = 0;  ///< mean over scans with proposals
  std::optional<Tempered> tempered{};
};

CombinedEstimate estimate_of(const archive::Source& source, const std::string& name,
                             std::uint64_t chains, std::size_t round) {
  const std::vector<double> values = of_ladders(source, name, chains, round);
  const std::vector<double> errors = of_ladders(source, name + "_error", chains, round);
  std::vector<LogEstimate> ladders;
  for (std::size_t i = 0; i < values.size(); ++i)
    ladders.push_back({.value = values[i], .error = errors[i]});
  return combined(ladders);
}

/// What annealed importance sampling's ascents say.
Tempered weighted_of(const archive::Source& source, std::uint64_t chains) {
  std::vector<LogEstimate> log_z;
  std::vector<LogEstimate> log_p;
  for (const AscentReport& chain : ascents_of(source, chains)) {
    log_z.push_back(chain.log_z);
    log_p.push_back(chain.log_p_satisfied);
  }
  return {.weighted = true,
          .log_z = combined(log_z),
          .log_p_satisfied = combined(log_p),
          .log_natural_throw = log_natural_throw(source)};
}

std::optional<Tempered> tempered_of(const archive::Source& source,
                                    const archive::Summary& summary) {
  const auto method = method_of(summary.request_text);
  if (method == request::Method::annealed_importance) return weighted_of(source, summary.chains);
  const std::vector<Round> rounds =
      rounds_of(source, summary.chains,
                burns_in(method) ? std::nullopt : std::optional<std::uint64_t>(summary.scans));
  if (rounds.empty()) return std::nullopt;
  const auto estimate = [&](const std::string& name, std::size_t round) {
    return estimate_of(source, name, summary.chains, round);
  };
  const std::size_t judged = judged_round(rounds);
  Tempered tempered{.burn_in = burns_in(method),
                    .rounds = rounds.size(),
                    .judged = judged,
                    .log_z = estimate("log_z", judged),
                    .satisfied_round = judged,
                    .log_p_satisfied = estimate("log_p_satisfied", judged),
                    .log_natural_throw = log_natural_throw(source)};
  // Where nothing satisfied there, the latest of the other rounds must do.
  for (std::size_t r = rounds.size(); r-- > 0 && tempered.log_p_satisfied.ladders == 0;) {
    tempered.satisfied_round = r;
    tempered.log_p_satisfied = estimate("log_p_satisfied", r);
  }
  tempered.without_trips =
      without_round_trip(source, summary.chains, tempered.satisfied_round).size();
  return tempered;
}

Facts facts_of(const archive::Source& source) {
  Facts facts{.summary = archive::summary_of(source)};
  const std::uint64_t scans = facts.summary.chains * facts.summary.scans;
  if (scans == 0) return facts;
  facts.tempered = tempered_of(source, facts.summary);
  facts.satisfied = sum_of(source, "satisfied") / static_cast<double>(scans);
  const std::uint64_t moving = facts.summary.chains * (facts.summary.scans - 1);
  if (moving > 0) {
    facts.acceptance = sum_of(source, "acceptance_rate") / static_cast<double>(moving);
  }
  return facts;
}

/// "9 kept (at most 3 of each of 4 chains)": the rule that bounds their number first.
std::string kept_animations(const archive::Summary& summary) {
  if (summary.keep_max <= 0) return "none kept (keep_max is 0)";
  if (summary.keep_per_lineage <= 0) return "none kept (keep_per_lineage is 0)";
  const auto most = static_cast<std::uint64_t>(summary.keep_max);
  const auto each = static_cast<std::uint64_t>(summary.keep_per_lineage);
  // All other methods have a way back to the prior.
  const bool one_lineage = method_of(summary.request_text) == request::Method::metropolis_hastings;
  if (one_lineage && summary.chains > 0 && each <= most / summary.chains) {
    return fmt::format("{} kept (at most {} of each of {} chains)", summary.animations, each,
                       summary.chains);
  }
  if (one_lineage) return fmt::format("{} kept (at most {} in all)", summary.animations, most);
  return fmt::format("{} kept (at most {} of each lineage, {} in all)", summary.animations, each,
                     most);
}

/// "-4.54 +- 0.02 (2 ladders, jackknife within ladders)"; weights are chains'.
std::string shown(const CombinedEstimate& estimate, bool weighted) {
  if (estimate.ladders == 0) return "unknown";
  const std::string from = fmt::format("{} {}{}", estimate.ladders, weighted ? "chain" : "ladder",
                                       estimate.ladders == 1 ? "" : "s");
  if (estimate.error_from == ErrorFrom::unknown) {
    return fmt::format("{:.2f} ({}, error unknown)", estimate.log.value, from);
  }
  return fmt::format("{:.2f} +- {:.2f} ({}, {})", estimate.log.value, estimate.log.error, from,
                     name_of(estimate.error_from, weighted));
}

void print_tempered(const Tempered& tempered, std::uint64_t chains) {
  const auto round_of = [&](std::size_t round) {
    return fmt::format("round {} of {}{}", round + 1, tempered.rounds,
                       tempered.burn_in ? " of the burn-in" : "");
  };
  const auto from_round = [&](std::size_t round) {
    return tempered.weighted ? std::string() : ", " + round_of(round);
  };
  const CombinedEstimate& odds = tempered.log_p_satisfied;
  fmt::print("  log Z        {}{}\n", shown(tempered.log_z, tempered.weighted),
             from_round(tempered.judged));
  if (odds.ladders == 0) {
    fmt::print("  by chance    unknown: nothing satisfied in any {}\n",
               tempered.weighted ? "draw" : "round");
    return;
  }
  fmt::print("  by chance    {}\n", in_words(odds_of(odds.log, tempered.log_natural_throw)));
  fmt::print("               log P {}{}\n", shown(odds, tempered.weighted),
             from_round(tempered.satisfied_round));
  if (tempered.satisfied_round != tempered.judged) {
    fmt::print("               of another round, since nothing satisfied in {}\n",
               round_of(tempered.judged));
  }
  if (odds.ladders < chains) {
    fmt::print(
        "               nothing satisfied in {} of {} {}, which are left out: it may be rarer\n",
        chains - odds.ladders, chains, tempered.weighted ? "chains" : "ladders");
  }
  // Their states are still on their way, all of them on the same side: no spread shows that.
  if (tempered.without_trips > 0) {
    fmt::print(
        "               {} of {} ladders made no round trip in that round: it may be far off\n",
        tempered.without_trips, chains);
  }
}

void print_for_people(const std::string& path, const Facts& facts) {
  const archive::Summary& summary = facts.summary;
  fmt::print("{}: {} samples\n\n", path, summary.world);
  if (!summary.warning.empty()) fmt::print("  warning      {}\n", summary.warning);
  fmt::print("  chains       {}\n", summary.chains);
  fmt::print("  scans        {} of each chain\n", summary.scans);
  fmt::print("  states       {} of each chain (every {}. scan)\n", summary.states, summary.thin);
  fmt::print("  satisfied    {:.1f}% of scans\n", 100 * facts.satisfied);
  fmt::print("  accepted     {:.1f}% of proposals\n", 100 * facts.acceptance);
  fmt::print("  animations   {}, {} segments of motion\n", kept_animations(summary),
             summary.segments);
  if (facts.tempered) print_tempered(*facts.tempered, summary.chains);
  fmt::print("  written by   sleight {}\n", summary.inference_library_version);
  fmt::print("  digest       {}\n\n", summary.content_digest);
  fmt::print("The request that reproduces it:\n\n{}", summary.request_text);
}

/// One throw in so many as a power of ten; numbers that are not known are null.
nlohmann::ordered_json as_json(const Tempered& tempered) {
  const ThrowOdds odds = odds_of(tempered.log_p_satisfied.log, tempered.log_natural_throw);
  const auto json_of = [&](const CombinedEstimate& estimate, std::size_t round) {
    nlohmann::ordered_json json{{"value", estimate.log.value},
                                {"error", estimate.log.error},
                                {"error_from", name_of(estimate.error_from, tempered.weighted)},
                                {"ladders", estimate.ladders}};
    if (!tempered.weighted) json["round"] = round + 1;
    return json;
  };
  nlohmann::ordered_json json{
      {"from", tempered.weighted  ? "weights"
               : tempered.burn_in ? "burn_in"
                                  : "ladders"},
      {"rounds", tempered.rounds},
      {"log_z", json_of(tempered.log_z, tempered.judged)},
      {"log_p_satisfied", json_of(tempered.log_p_satisfied, tempered.satisfied_round)},
      {"ladders_without_round_trip", tempered.without_trips},
      {"log_natural_throw", tempered.log_natural_throw},
      {"log10_throws", odds.log10_throws},
      {"log10_throws_low", odds.log10_low},
      {"log10_throws_high", odds.log10_high}};
  if (tempered.weighted) {
    json.erase("rounds");
    json.erase("ladders_without_round_trip");
  }
  return json;
}

nlohmann::ordered_json as_json(const std::string& path, const Facts& facts) {
  const archive::Summary& summary = facts.summary;
  nlohmann::ordered_json json{{"archive", path},
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
                              {"version", summary.inference_library_version},
                              {"digest", summary.content_digest},
                              {"request", summary.request_text}};
  if (facts.tempered) json["tempering"] = as_json(*facts.tempered);
  return json;
}

void export_to_file(const archive::Source& source, const ExportOptions& options,
                    const std::string& path) {
  errno = 0;
  std::ofstream file(path);
  if (file) {
    archive::export_csv(source, options.table, file);
    file.close();
  }
  if (!file) {
    throw base::Error(fmt::format("{}: can't write it: {}", options.output,
                                  errno != 0 ? std::strerror(errno) : "is the disk full?"));
  }
}

}  // namespace

int archive_info(const std::string& path, bool json) {
  return with_archive(path, [&](const archive::Source& source) {
    const Facts facts = facts_of(source);
    if (json) {
      fmt::print("{}\n", dumped(as_json(path, facts)));
    } else {
      print_for_people(path, facts);
    }
    return k_ok;
  });
}

int archive_digest(const std::string& path, bool json) {
  return with_archive(path, [&](const archive::Source& source) {
    const std::string digest = archive::digest(source);
    if (json) {
      fmt::print("{}\n", dumped({{"archive", path}, {"digest", digest}}));
    } else {
      fmt::print("{}\n", digest);
    }
    return k_ok;
  });
}

int archive_verify(const std::string& path, bool json) {
  return with_archive(path, [&](const archive::Source& source) {
    const std::vector<std::string> findings = archive::verify(source);
    if (json) {
      fmt::print("{}\n",
                 dumped({{"archive", path}, {"ok", findings.empty()}, {"findings", findings}}));
    } else {
      for (const std::string& finding : findings)
        fmt::print("{}: {}\n", path, finding);
      if (findings.empty()) fmt::print("{}: ok\n", path);
    }
    return findings.empty() ? k_ok : k_bad_archive;
  });
}

int archive_export_csv(const ExportOptions& options) {
  if (options.output.empty() || options.output == "-") {
    return with_archive(options.path, [&](const archive::Source& source) {
      archive::export_csv(source, options.table, std::cout);
      return k_ok;
    });
  }
  refuse_same_file(options.path, options.output);
  OutputBeside output(options.output);
  const int code = with_archive(options.path, [&](const archive::Source& source) {
    export_to_file(source, options, output.path());
    return k_ok;
  });
  if (code == k_ok) output.put_in_place();
  return code;
}

}  // namespace sleight::cli
