#include "clients/gallery_server/series.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>
#include <variant>
#include <vector>

#include <fmt/format.h>

#include "clients/analysis/archive_rows.h"
#include "clients/analysis/diagnosis.h"
#include "clients/analysis/sampling_method.h"
#include "clients/analysis/scalar_draws.h"
#include "clients/analysis/tempering.h"
#include "clients/gallery_server/checked_read.h"
#include "clients/gallery_server/packed.h"
#include "clients/gallery_server/refused.h"
#include "clients/pictures/trace.h"
#include "common/archive/format.h"

namespace sleight::gallery {
namespace {

using Json = json::Value;

/// Maximum number of posterior values in a histogram; from more values, every n-th is used.
constexpr std::uint64_t k_histogram_draws_max = 1'000'000;
constexpr std::string_view k_trace_prefix = "trace.";
constexpr std::string_view k_pair_prefix = "pair.";
constexpr const char* k_index_title = "level of each replica (the index process)";

[[noreturn]] void refuse_plot() {
  throw Refused(k_not_found, "This plot doesn't exist.", "Reload the page.");
}

std::string unit_of(const archive::Source& source, std::string_view group, std::string_view name) {
  const archive::DatasetSpec* spec = dataset_of(source, group, name);
  const archive::Attribute* unit =
      spec == nullptr ? nullptr : archive::find_attribute(spec->attributes, "units");
  const auto* text = unit == nullptr ? nullptr : std::get_if<std::string>(&unit->value);
  return text == nullptr ? "1" : *text;
}

/// Names of the numbers along chains: the numbers that all worlds have, and the world's outcomes.
std::vector<std::string> traced(const archive::Source& source) {
  std::vector<std::string> names{"log_constraint", "log_prior", "lp", "acceptance_rate"};
  for (std::string& name : analysis::outcome_names(source))
    names.push_back(std::move(name));
  return names;
}

std::string title_of(std::string_view name) {
  if (name == "log_constraint") return "score: log of the constraint's density";
  if (name == "log_prior") return "log p: log density under the model";
  if (name == "lp") return "lp: sum of log p and score";
  if (name == "acceptance_rate") return "acceptance of proposals";
  return std::string(name);
}

/// Names that both prior draws and chains have.
std::vector<std::string> paired(const archive::Source& source) {
  std::vector<std::string> names;
  const std::uint64_t draws = prior_draws_of(source);
  for (const std::string& name : traced(source)) {
    if (draws > 0 && has_numbers(source, archive::k_sample_stats_prior, name, draws))
      names.push_back(name);
  }
  return names;
}

/// The kind of proposal that changes all variables; none if the method has no such kind.
std::optional<std::size_t> change_all_kind(const std::vector<std::string>& kinds) {
  const auto found = std::ranges::find_if(
      kinds, [](const std::string& kind) { return kind == "all" || kind == "change_all"; });
  if (found == kinds.end()) return std::nullopt;
  return static_cast<std::size_t>(found - kinds.begin());
}

/// Adds the columns of a chain's marked draws.
void add_marks(Packed& to, const archive::Source& source, const archive::Summary& summary,
               std::uint64_t chain) {
  const std::vector<std::string> kinds = analysis::proposal_kinds(source);
  const auto all = change_all_kind(kinds);
  const std::uint64_t draws = summary.scans;
  std::vector<std::uint32_t> change_all;
  std::vector<std::uint32_t> fall;
  std::vector<std::uint32_t> other_lineage;
  double before = 0;
  double lineage_before = std::numeric_limits<double>::quiet_NaN();
  for (std::uint64_t first = 0; first < draws; first += k_rows_at_once) {
    const std::uint64_t count = std::min(k_rows_at_once, draws - first);
    const auto column = [&](std::string_view name, std::uint64_t width) {
      return checked_numbers(source, archive::k_sample_stats, name, summary.chains * draws * width,
                             (chain * draws + first) * width, count * width);
    };
    const std::vector<double> satisfied = column("satisfied", 1);
    const std::vector<double> lineage = column("lineage", 1);
    const std::vector<double> accepted =
        all ? column("accepted", kinds.size()) : std::vector<double>();
    for (std::uint64_t i = 0; i < count; ++i) {
      const auto draw = static_cast<std::uint32_t>(first + i);
      if (all && draw > 0 && accepted[i * kinds.size() + *all] > 0) change_all.push_back(draw);
      if (before != 0 && satisfied[i] == 0) fall.push_back(draw);
      if (draw > 0 && lineage[i] != lineage_before) other_lineage.push_back(draw);
      before = satisfied[i];
      lineage_before = lineage[i];
    }
  }
  to.add("change_all", change_all);
  to.add("fall", fall);
  to.add("lineage", other_lineage);
}

std::string trace_of(const archive::Source& source, const archive::Summary& summary,
                     std::string_view name, std::uint64_t chain) {
  const std::vector<plot::Point> points =
      pictures::trace(source, name, {.chain = chain, .points_max = k_series_points_max}, 1);
  std::vector<double> draw;
  std::vector<double> value;
  draw.reserve(points.size());
  value.reserve(points.size());
  for (const plot::Point& point : points) {
    draw.push_back(point.x);
    value.push_back(point.y);
  }
  Packed packed;
  packed.add("draw", draw);
  packed.add("value", value);
  add_marks(packed, source, summary, chain);
  return packed.finish({{"kind", "trace"},
                        {"title", title_of(name)},
                        {"unit", unit_of(source, archive::k_sample_stats, name)},
                        {"chain", chain},
                        {"chains", summary.chains},
                        {"draws", summary.scans},
                        {"is_thinned", summary.scans > k_series_points_max}});
}

/// Rounds of the ladders; empty if the archive has none.
std::vector<analysis::Round> rounds(const archive::Source& source,
                                    const archive::Summary& summary) {
  if (archive::find_group(source, archive::k_tempering) == nullptr) return {};
  const auto method = analysis::method_of(summary.request_text);
  return analysis::rounds_of(
      source, summary.chains,
      analysis::burns_in(method) ? std::nullopt : std::optional<std::uint64_t>(summary.scans));
}

std::string levels_of(const archive::Source& source, const archive::Summary& summary,
                      std::uint64_t chain) {
  const std::vector<std::string> kinds = analysis::proposal_kinds(source);
  std::vector<double> round;
  std::vector<double> level;
  std::vector<double> inverse_temperature;
  std::vector<double> swaps;
  std::vector<std::vector<double>> acceptance(kinds.size());
  const std::size_t count = rounds(source, summary).size();
  for (std::size_t i = 0; i < count; ++i) {
    const analysis::Ladder ladder = analysis::ladder_of(source, chain, i);
    for (std::size_t l = 0; l < ladder.inverse_temperature.size(); ++l) {
      round.push_back(static_cast<double>(i + 1));
      level.push_back(static_cast<double>(l));
      inverse_temperature.push_back(ladder.inverse_temperature[l]);
      swaps.push_back(l < ladder.swap_acceptance.size() ? ladder.swap_acceptance[l]
                                                        : std::numeric_limits<double>::quiet_NaN());
      for (std::size_t kind = 0; kind < kinds.size(); ++kind) {
        const bool is_known = l < ladder.acceptance.size() && kind < ladder.acceptance[l].size();
        acceptance[kind].push_back(is_known ? ladder.acceptance[l][kind]
                                            : std::numeric_limits<double>::quiet_NaN());
      }
    }
  }
  Packed packed;
  packed.add("round", round);
  packed.add("level", level);
  packed.add("inverse_temperature", inverse_temperature);
  packed.add("swap_acceptance", swaps);
  for (std::size_t kind = 0; kind < kinds.size(); ++kind)
    packed.add(fmt::format("acceptance.{}", kind), acceptance[kind]);
  return packed.finish({{"kind", "levels"},
                        {"title", "the ladder and its swap rates"},
                        {"chain", chain},
                        {"chains", summary.chains},
                        {"rounds", count},
                        {"kinds", kinds}});
}

std::string rounds_table(const archive::Source& source, const archive::Summary& summary,
                         std::uint64_t chain) {
  const std::vector<analysis::Round> all = rounds(source, summary);
  std::vector<double> round;
  std::vector<double> first_scan;
  std::vector<double> scans;
  for (std::size_t i = 0; i < all.size(); ++i) {
    round.push_back(static_cast<double>(i + 1));
    first_scan.push_back(static_cast<double>(all[i].first_scan));
    scans.push_back(static_cast<double>(all[i].scans));
  }
  Packed packed;
  packed.add("round", round);
  packed.add("first_scan", first_scan);
  packed.add("scans", scans);
  const auto add = [&](std::string_view column, const char* dataset, bool is_rate) {
    std::vector<double> values;
    for (std::size_t i = 0; i < all.size(); ++i) {
      const double value = analysis::of_ladders(source, dataset, summary.chains, i)[chain];
      values.push_back(is_rate ? value * scans[i] : value);
    }
    packed.add(column, values);
  };
  add("round_trips", "round_trips", false);
  add("predicted_round_trips", "predicted_round_trip_rate", true);
  add("restarts", "restarts", false);
  add("barrier", "barrier", false);
  return packed.finish({{"kind", "rounds"},
                        {"title", "round trips from prior to target and back, in each round"},
                        {"chain", chain},
                        {"chains", summary.chains},
                        {"rounds", all.size()}});
}

std::string index_of(const archive::Source& source, const archive::Summary& summary,
                     std::uint64_t chain) {
  const analysis::IndexProcess process = analysis::index_process_of(source, chain);
  std::vector<double> begins;
  for (const analysis::Round& round : rounds(source, summary))
    begins.push_back(static_cast<double>(round.first_scan));
  Packed packed;
  packed.add("scan", process.scan);
  packed.add("round", begins);
  for (std::size_t replica = 0; replica < process.level.size(); ++replica)
    packed.add(fmt::format("level.{}", replica), process.level[replica]);
  return packed.finish({{"kind", "index"},
                        {"title", k_index_title},
                        {"chain", chain},
                        {"chains", summary.chains},
                        {"replicas", process.level.size()}});
}

/// The numbers of all chains with their weights; only every n-th number if there are too many.
struct Weighed {
  std::vector<double> values{};
  std::vector<double> log_weights{};  ///< empty: equal weights
};

Weighed posterior_of(const archive::Source& source, const archive::Summary& summary,
                     std::string_view name) {
  Weighed weighed;
  const std::uint64_t draws = summary.chains * summary.scans;
  const std::uint64_t every = 1 + (draws - 1) / k_histogram_draws_max;
  const bool has_weights = has_numbers(source, archive::k_tempering, "log_weight", draws);
  for (std::uint64_t first = 0; first < draws; first += k_rows_at_once) {
    const std::uint64_t rows = std::min(k_rows_at_once, draws - first);
    const auto column = [&](std::string_view group, std::string_view dataset) {
      return checked_numbers(source, group, dataset, draws, first, rows);
    };
    const std::vector<double> values = column(archive::k_sample_stats, name);
    const std::vector<double> logs =
        has_weights ? column(archive::k_tempering, "log_weight") : std::vector<double>();
    for (std::uint64_t i = 0; i < rows; ++i) {
      if ((first + i) % every != 0) continue;
      weighed.values.push_back(values[i]);
      if (has_weights) weighed.log_weights.push_back(logs[i]);
    }
  }
  return weighed;
}

/// Returns the shares of the finite values by bin. REQUIRES: ascending edges.
std::vector<double> histogram(const Weighed& of, const std::vector<double>& edges) {
  std::vector<double> shares(edges.size() - 1, 0.0);
  double greatest = 0;
  if (!of.log_weights.empty()) greatest = *std::ranges::max_element(of.log_weights);
  double sum = 0;
  for (std::size_t i = 0; i < of.values.size(); ++i) {
    if (!std::isfinite(of.values[i])) continue;
    const double weight = of.log_weights.empty() ? 1.0 : std::exp(of.log_weights[i] - greatest);
    if (!std::isfinite(weight)) continue;
    const auto above = std::ranges::upper_bound(edges, of.values[i]) - edges.begin();
    const auto last = static_cast<std::ptrdiff_t>(shares.size());
    shares[static_cast<std::size_t>(std::clamp<std::ptrdiff_t>(above, 1, last) - 1)] += weight;
    sum += weight;
  }
  if (sum > 0) {
    for (double& share : shares)
      share /= sum;
  }
  return shares;
}

std::string pair_of(const archive::Source& source, const archive::Summary& summary,
                    std::string_view name) {
  const std::uint64_t draws = prior_draws_of(source);
  const Weighed prior{
      .values = checked_numbers(source, archive::k_sample_stats_prior, name, draws, 0, draws)};
  const Weighed posterior = posterior_of(source, summary, name);
  double low = std::numeric_limits<double>::infinity();
  double high = -low;
  for (const Weighed* one : {&prior, &posterior}) {
    for (const double value : one->values) {
      if (!std::isfinite(value)) continue;
      low = std::min(low, value);
      high = std::max(high, value);
    }
  }
  if (!(low <= high)) low = high = 0;
  if (low == high) high = low + 1;
  std::vector<double> edges;
  for (std::size_t i = 0; i <= k_bins; ++i)
    edges.push_back(low + (high - low) * static_cast<double>(i) / static_cast<double>(k_bins));
  Packed packed;
  packed.add("edges", edges);
  packed.add("prior", histogram(prior, edges));
  packed.add("posterior", histogram(posterior, edges));
  return packed.finish({{"kind", "pair"},
                        {"title", fmt::format("{}: prior and posterior", name)},
                        {"unit", unit_of(source, archive::k_sample_stats, name)},
                        {"prior_draws", prior.values.size()},
                        {"draws", posterior.values.size()},
                        {"is_weighted", !posterior.log_weights.empty()}});
}

Json titles_in(const archive::Source& source, const archive::Summary& summary) {
  Json titles = Json::array();
  const auto add = [&](std::string name, std::string title, const char* kind, const char* group) {
    titles.push_back(
        {{"name", std::move(name)}, {"title", std::move(title)}, {"kind", kind}, {"group", group}});
  };
  const std::uint64_t draws = summary.chains * summary.scans;
  if (draws == 0 || draws > k_counted_draws_max) return titles;
  for (const std::string& name : traced(source))
    add(std::string(k_trace_prefix) + name, title_of(name), "trace", "along the chain");
  add("trace.lineage", "lineage: each draw descends from one visit to the prior", "trace",
      "along the chain");
  if (!rounds(source, summary).empty()) {
    add("ladder", "the ladder and its swap rates", "levels", "ladder");
    add("rounds", "round trips from prior to target and back, in each round", "rounds", "ladder");
    if (dataset_of(source, archive::k_tempering, "index_level") != nullptr)
      add("index", k_index_title, "index", "ladder");
  }
  for (const std::string& name : paired(source))
    add(std::string(k_pair_prefix) + name, title_of(name), "pair", "prior against posterior");
  if (analysis::why_not_diagnosed(source, summary).empty())
    add("diagnosis", "Have the chains mixed?", "table", "diagnosis");
  return titles;
}

std::uint64_t chain_of(std::string_view text, const archive::Summary& summary) {
  std::uint64_t chain = 0;
  const auto [end, failure] = std::from_chars(text.data(), text.data() + text.size(), chain);
  if (failure != std::errc() || end != text.data() + text.size() || chain >= summary.chains)
    throw Refused(k_not_found, "This chain doesn't exist.", "Chains are counted from 0.");
  return chain;
}

std::string series_in(const archive::Source& source, const archive::Summary& summary,
                      std::string_view name, std::string_view chain_text) {
  const Json titles = titles_in(source, summary);
  const bool is_one = std::ranges::any_of(
      titles.elements(), [&](const Json& title) { return title["name"].text() == name; });
  if (!is_one || name == "diagnosis") refuse_plot();
  if (name.starts_with(k_pair_prefix))
    return pair_of(source, summary, name.substr(k_pair_prefix.size()));
  const std::uint64_t chain = chain_of(chain_text, summary);
  if (name == "ladder") return levels_of(source, summary, chain);
  if (name == "rounds") return rounds_table(source, summary, chain);
  if (name == "index") return index_of(source, summary, chain);
  return trace_of(source, summary, name.substr(k_trace_prefix.size()), chain);
}

}  // namespace

Json series_titles(const Snapshot& snapshot) {
  Json titles;
  snapshot.read(
      [&](const archive::Source& source) { titles = titles_in(source, snapshot.facts().summary); });
  return titles;
}

std::string series_of(const Snapshot& snapshot, std::string_view name, std::string_view chain) {
  std::string bytes;
  snapshot.read([&](const archive::Source& source) {
    bytes = series_in(source, snapshot.facts().summary, name, chain);
  });
  return bytes;
}

}  // namespace sleight::gallery
