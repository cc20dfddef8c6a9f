#include "clients/cli/trace.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>
#include <variant>

#include "common/archive/format.h"
#include "common/base/error.h"

namespace sleight::cli {
namespace {

/// What /sample_stats holds of every world; all else of dims (chain, draw) are its outcomes.
constexpr std::array<std::string_view, 6> k_common = {"lp",        "log_prior", "log_constraint",
                                                      "satisfied", "lineage",   "acceptance_rate"};

const archive::DatasetSpec& dataset_of(const archive::Source& source, std::string_view group,
                                       std::string_view name) {
  const archive::Group* found = archive::find_group(source, group);
  const archive::DatasetSpec* spec =
      found == nullptr ? nullptr : archive::find_dataset(*found, name);
  if (spec == nullptr) {
    throw base::Error(base::ExitCode::bad_archive, fmt::format("{}: no dataset {}", source.name(),
                                                               archive::path_of(group, name)));
  }
  return *spec;
}

std::vector<double> as_doubles(const archive::Values& values) {
  return std::visit(
      [](const auto& held) -> std::vector<double> {
        using Element = typename std::decay_t<decltype(held)>::value_type;
        if constexpr (std::is_arithmetic_v<Element>) {
          std::vector<double> numbers(held.size());
          std::transform(held.begin(), held.end(), numbers.begin(),
                         [](Element element) { return static_cast<double>(element); });
          return numbers;
        } else {
          return {};
        }
      },
      values);
}

}  // namespace

std::uint64_t stats_size(const archive::Source& source, std::string_view dimension) {
  return archive::element_count(dataset_of(source, archive::k_sample_stats, dimension));
}

std::vector<plot::Point> trace(const archive::Source& source, std::string_view variable,
                               const TraceRange& range, double scale) {
  dataset_of(source, archive::k_sample_stats, variable);
  const std::uint64_t chains = stats_size(source, "chain");
  const std::uint64_t draws = stats_size(source, "draw");
  if (range.chain >= chains) {
    throw base::Error(base::ExitCode::usage, fmt::format("{}: no chain {}; it has chains 0 to {}",
                                                         source.name(), range.chain, chains - 1));
  }
  const std::uint64_t count = range.draws == 0 ? draws : std::min(range.draws, draws);
  const std::vector<double> values =
      as_doubles(source.read(archive::k_sample_stats, variable, range.chain * draws, count));
  std::vector<plot::Point> points(values.size());
  for (std::size_t i = 0; i < values.size(); ++i) {
    points[i] = {static_cast<double>(i), scale * values[i]};
  }
  return points;
}

std::vector<std::string> outcome_names(const archive::Source& source) {
  std::vector<std::string> names;
  const archive::Group* stats = archive::find_group(source, archive::k_sample_stats);
  if (stats == nullptr) return names;
  for (const archive::DatasetSpec& spec : stats->datasets) {
    if (spec.dims.size() != 2 || spec.type != archive::ElementType::f64) continue;
    if (std::find(k_common.begin(), k_common.end(), spec.name) == k_common.end()) {
      names.push_back(spec.name);
    }
  }
  return names;
}

std::vector<double> read_numbers(const archive::Source& source, std::string_view group,
                                 std::string_view dataset) {
  const archive::DatasetSpec& spec = dataset_of(source, group, dataset);
  return as_doubles(source.read(group, dataset, 0, archive::element_count(spec)));
}

}  // namespace sleight::cli
