#include "clients/analysis/tempering.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "clients/analysis/throw_odds.h"
#include "common/archive/format.h"
#include "common/base/error.h"

namespace sleight::analysis {
namespace {

[[noreturn]] void refuse(const archive::Source& source, std::string_view name,
                         std::string_view reason) {
  throw base::Error(base::ExitCode::bad_archive,
                    fmt::format("{}: {}: {}", source.name(),
                                archive::path_of(archive::k_tempering, name), reason));
}

/// Returns a limit above any table's size along a dimension.
std::uint64_t most_along(std::string_view dim) {
  if (dim == "chain" || dim == "draw" || dim == "island") return k_run_scans_max;
  if (dim == "round") return k_rounds_max;
  if (dim == "proposal_kind") return k_kinds_max;
  if (dim == "moment") return k_moments_max;
  return dim == "level" || dim == "walk_level" || dim == "replica" ? k_levels_max : k_steps_max;
}

using Names = std::vector<std::string_view>;

/// Returns the dataset if it exists. Throws on an unexpected type, rank or size.
const archive::DatasetSpec* find_table(const archive::Source& source, std::string_view name,
                                       const Names& dims) {
  const archive::Group* group = archive::find_group(source, archive::k_tempering);
  const archive::DatasetSpec* spec = group == nullptr ? nullptr : find_dataset(*group, name);
  if (spec == nullptr) return nullptr;
  if (spec->type != archive::ElementType::f64 ||
      !std::ranges::equal(spec->dims, dims, {}, &archive::Dimension::name)) {
    refuse(source, name,
           fmt::format("expected numbers with the dimensions ({})", fmt::join(dims, ", ")));
  }
  for (const archive::Dimension& dim : spec->dims) {
    if (dim.size > most_along(dim.name))
      refuse(source, name,
             fmt::format("more than {} entries along {}", most_along(dim.name), dim.name));
  }
  return spec;
}

const Names k_by_round{"chain", "round"};
const Names k_by_level{"chain", "round", "level"};
const Names k_by_kind{"chain", "round", "level", "proposal_kind"};

/// Returns the entries of one ladder in one round; empty if the archive has no such table.
std::vector<double> read_entries(const archive::Source& source, std::string_view name,
                                 std::uint64_t chain, std::size_t round, const Names& dims) {
  const archive::DatasetSpec* spec = find_table(source, name, dims);
  if (spec == nullptr) return {};
  if (chain >= spec->dims[0].size || round >= spec->dims[1].size) {
    refuse(source, name, fmt::format("no round {} of chain {}", round, chain));
  }
  std::uint64_t width = 1;
  for (std::size_t d = 2; d < spec->dims.size(); ++d)
    width *= spec->dims[d].size;
  return std::get<std::vector<double>>(
      source.read(archive::k_tempering, name, (chain * spec->dims[1].size + round) * width, width));
}

/// Converts a count stored as a double. Throws if the value isn't a count or is above `most`.
std::uint64_t count_of(const archive::Source& source, std::string_view name, double value,
                       std::uint64_t most) {
  if (!(value >= 0 && value <= static_cast<double>(most)) || value != std::floor(value)) {
    refuse(source, name, fmt::format("{} is not a whole number from 0 to {}", value, most));
  }
  return static_cast<std::uint64_t>(value);
}

}  // namespace

std::vector<Round> rounds_of(const archive::Source& source, std::uint64_t chains,
                             std::optional<std::uint64_t> draws) {
  const archive::DatasetSpec* first = find_table(source, "first_scan", k_by_round);
  if (first == nullptr) return {};
  if (first->dims[0].size != chains) refuse(source, "first_scan", "unexpected number of chains");
  std::vector<Round> rounds;
  std::uint64_t end = k_run_scans_max;
  for (std::size_t r = 0; r < first->dims[1].size; ++r) {
    // Some ladders may not have begun the last round.
    const std::vector<double> begins = of_ladders(source, "first_scan", chains, r);
    if (std::ranges::any_of(begins, [](double begin) { return std::isnan(begin); })) break;
    if (std::ranges::any_of(begins, [&](double begin) { return begin != begins[0]; })) {
      refuse(source, "first_scan", "rounds of different chains begin at different scans");
    }
    Round round{.first_scan = count_of(source, "first_scan", begins[0], end), .scans = 0};
    if (r == 0 && draws) end = round.first_scan + std::min(*draws, k_run_scans_max);
    round.scans = end - round.first_scan;
    for (const double length : of_ladders(source, "scans", chains, r)) {
      round.scans =
          std::min(round.scans, count_of(source, "scans", length, end - round.first_scan));
    }
    if (round.scans == 0) break;
    rounds.push_back(round);
  }
  return rounds;
}

Round draws_of_round(std::span<const Round> rounds, std::size_t round) {
  return {.first_scan = rounds[round].first_scan - rounds[0].first_scan,
          .scans = rounds[round].scans};
}

std::size_t judged_round(std::span<const Round> rounds) {
  std::size_t best = 0;
  for (std::size_t r = 1; r < rounds.size(); ++r) {
    if (rounds[r].scans >= rounds[best].scans) best = r;
  }
  return best;
}

std::vector<double> of_ladders(const archive::Source& source, std::string_view name,
                               std::uint64_t chains, std::size_t round) {
  const archive::DatasetSpec* spec = find_table(source, name, k_by_round);
  if (spec == nullptr) return std::vector<double>(chains, k_nan);
  const std::uint64_t rounds = spec->dims[1].size;
  if (chains > spec->dims[0].size || round >= rounds) {
    refuse(source, name, fmt::format("no round {} of chain {}", round, chains - 1));
  }
  std::vector<double> values;
  const std::uint64_t batch = archive::k_batch_elements / rounds;
  for (std::uint64_t first = 0; first < chains; first += batch) {
    const std::uint64_t count = std::min(batch, chains - first);
    const auto rows = std::get<std::vector<double>>(
        source.read(archive::k_tempering, name, first * rounds, count * rounds));
    for (std::uint64_t c = 0; c < count; ++c)
      values.push_back(rows[c * rounds + round]);
  }
  return values;
}

std::vector<std::uint64_t> without_round_trip(const archive::Source& source, std::uint64_t chains,
                                              std::size_t round) {
  const std::vector<double> trips = of_ladders(source, "round_trips", chains, round);
  std::vector<std::uint64_t> ladders;
  for (std::uint64_t c = 0; c < chains; ++c) {
    if (trips[c] < 1) ladders.push_back(c);
  }
  return ladders;
}

Ladder ladder_of(const archive::Source& source, std::uint64_t chain, std::size_t round) {
  Ladder ladder{
      .inverse_temperature = read_entries(source, "inverse_temperature", chain, round, k_by_level),
      .swap_acceptance = read_entries(source, "swap_acceptance", chain, round, k_by_level),
      .local_barrier = read_entries(source, "local_barrier", chain, round, k_by_level),
      .acceptance = {}};
  // Each row has room for the largest ladder. Unused levels are NaN.
  const auto end = std::ranges::find_if(ladder.inverse_temperature,
                                        [](double beta) { return std::isnan(beta); });
  const auto levels = static_cast<std::size_t>(end - ladder.inverse_temperature.begin());
  ladder.inverse_temperature.resize(levels);
  ladder.swap_acceptance.resize(levels == 0 ? 0 : levels - 1, k_nan);
  ladder.local_barrier.resize(levels, k_nan);
  const std::vector<double> kinds = read_entries(source, "acceptance", chain, round, k_by_kind);
  if (kinds.empty()) return ladder;
  const archive::DatasetSpec* spec = find_table(source, "acceptance", k_by_kind);
  const std::size_t width = spec->dims[3].size;
  for (std::size_t level = 0; level < std::min(levels, spec->dims[2].size); ++level) {
    const auto row = kinds.begin() + static_cast<std::ptrdiff_t>(level * width);
    ladder.acceptance.emplace_back(row, row + static_cast<std::ptrdiff_t>(width));
  }
  return ladder;
}

IndexProcess index_process_of(const archive::Source& source, std::uint64_t chain) {
  constexpr std::string_view k_name = "index_level";
  IndexProcess process{.scan = row_of_chain(source, "index_scan", "moment", chain), .level = {}};
  const archive::DatasetSpec* spec = find_table(source, k_name, {"chain", "moment", "replica"});
  if (process.scan.empty() || spec == nullptr || spec->dims[2].size == 0) return {};
  const std::uint64_t moments = spec->dims[1].size;
  const std::uint64_t replicas = spec->dims[2].size;
  if (chain >= spec->dims[0].size || moments != process.scan.size())
    refuse(source, k_name, "expected the same numbers of chains and moments as index_scan has");
  // Each row has room for the largest number of moments. Unused moments are NaN.
  const auto end = std::ranges::find_if(process.scan, [](double scan) { return std::isnan(scan); });
  process.scan.erase(end, process.scan.end());
  if (!std::ranges::is_sorted(process.scan))
    refuse(source, "index_scan", "scans are not in ascending order");
  process.level.assign(replicas, std::vector<double>(process.scan.size(), k_nan));
  const std::uint64_t batch = std::max<std::uint64_t>(1, archive::k_batch_elements / replicas);
  for (std::uint64_t first = 0; first < process.scan.size(); first += batch) {
    const std::uint64_t count = std::min<std::uint64_t>(batch, process.scan.size() - first);
    const auto levels = std::get<std::vector<double>>(source.read(
        archive::k_tempering, k_name, (chain * moments + first) * replicas, count * replicas));
    for (std::uint64_t i = 0; i < levels.size(); ++i)
      process.level[i % replicas][first + i / replicas] = levels[i];
  }
  return process;
}

std::vector<double> of_chains(const archive::Source& source, std::string_view name,
                              std::uint64_t chains) {
  const archive::DatasetSpec* spec = find_table(source, name, {"chain"});
  if (spec == nullptr) return std::vector<double>(chains, k_nan);
  if (chains > spec->dims[0].size) refuse(source, name, "too few chains");
  std::vector<double> all;
  for (std::uint64_t first = 0; first < chains; first += archive::k_batch_elements) {
    const std::uint64_t count = std::min<std::uint64_t>(archive::k_batch_elements, chains - first);
    const auto batch =
        std::get<std::vector<double>>(source.read(archive::k_tempering, name, first, count));
    all.insert(all.end(), batch.begin(), batch.end());
  }
  return all;
}

std::vector<double> row_of_chain(const archive::Source& source, std::string_view name,
                                 std::string_view dimension, std::uint64_t chain) {
  const archive::DatasetSpec* spec = find_table(source, name, {"chain", dimension});
  if (spec == nullptr) return {};
  if (chain >= spec->dims[0].size) refuse(source, name, fmt::format("no chain {}", chain));
  const std::uint64_t width = spec->dims[1].size;
  return std::get<std::vector<double>>(
      source.read(archive::k_tempering, name, chain * width, width));
}

void for_each_of_draws(const archive::Source& source, std::string_view name,
                       const std::function<void(double)>& visit) {
  const archive::DatasetSpec* spec = find_table(source, name, {"chain", "draw"});
  if (spec == nullptr) return;
  const std::uint64_t all = spec->dims[0].size * spec->dims[1].size;
  for (std::uint64_t first = 0; first < all; first += archive::k_batch_elements) {
    const std::uint64_t count = std::min<std::uint64_t>(archive::k_batch_elements, all - first);
    const auto values =
        std::get<std::vector<double>>(source.read(archive::k_tempering, name, first, count));
    for (const double value : values)
      visit(value);
  }
}

std::optional<std::uint64_t> islands_of_chain(const archive::Source& source, std::string_view name,
                                              std::uint64_t chains) {
  const archive::DatasetSpec* spec = find_table(source, name, {"chain", "island"});
  if (spec == nullptr) return std::nullopt;
  if (spec->dims[0].size != chains) refuse(source, name, "unexpected number of chains");
  const std::uint64_t islands = spec->dims[1].size;
  if (chains > 0 && islands > k_run_scans_max / chains) refuse(source, name, "too many islands");
  return islands;
}

void for_each_of_islands(const archive::Source& source, std::string_view name, IslandRange islands,
                         const std::function<void(double)>& visit) {
  const archive::DatasetSpec* spec = find_table(source, name, {"chain", "island"});
  if (spec == nullptr) return;
  const std::uint64_t all = spec->dims[1].size;
  const std::uint64_t end = std::min(islands.end.value_or(all), all);
  for (std::uint64_t chain = 0; chain < spec->dims[0].size; ++chain) {
    for (std::uint64_t begin = islands.first; begin < end; begin += archive::k_batch_elements) {
      const std::uint64_t count = std::min<std::uint64_t>(archive::k_batch_elements, end - begin);
      const auto values = std::get<std::vector<double>>(
          source.read(archive::k_tempering, name, chain * all + begin, count));
      for (const double value : values) {
        if (!(value < std::numeric_limits<double>::infinity()))
          refuse(source, name, fmt::format("expected the log of an estimate, found {}", value));
        visit(value);
      }
    }
  }
}

std::optional<std::uint64_t> island_of_all(const archive::Source& source, std::string_view name,
                                           std::uint64_t chains, std::uint64_t islands) {
  if (find_table(source, name, {"chain"}) == nullptr) return std::nullopt;
  const std::vector<double> numbers = of_chains(source, std::string(name), chains);
  if (numbers.empty()) return std::nullopt;
  if (std::ranges::any_of(numbers, [&](double other) { return other != numbers.front(); }))
    refuse(source, name, "the value differs between chains");
  return count_of(source, name, numbers.front(), islands);
}

std::vector<std::string> proposal_kinds(const archive::Source& source) {
  const archive::Group* stats = archive::find_group(source, archive::k_sample_stats);
  const archive::DatasetSpec* spec =
      stats == nullptr ? nullptr : find_dataset(*stats, "proposal_kind");
  if (spec == nullptr || spec->type != archive::ElementType::text || spec->dims.size() != 1 ||
      spec->dims[0].size > k_kinds_max) {
    throw base::Error(
        base::ExitCode::bad_archive,
        source.name() + ": /sample_stats/proposal_kind: expected a short list of names");
  }
  return std::get<std::vector<std::string>>(
      source.read(archive::k_sample_stats, "proposal_kind", 0, spec->dims[0].size));
}

double log_natural_throw(const archive::Source& source) {
  const archive::Group* group = archive::find_group(source, archive::k_tempering);
  const archive::Attribute* found =
      group == nullptr ? nullptr : find_attribute(group->attributes, "log_natural_throw");
  const double* value = found == nullptr ? nullptr : std::get_if<double>(&found->value);
  return value != nullptr && std::isfinite(*value) ? *value : 0;
}

}  // namespace sleight::analysis
