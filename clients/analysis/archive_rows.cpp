#include "clients/analysis/archive_rows.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <span>
#include <type_traits>
#include <variant>

#include "common/archive/format.h"
#include "common/base/error.h"

namespace sleight::analysis {
namespace {

/// Variables of /sample_stats in every world. Other variables over (chain, draw) are the world's
/// outcomes.
constexpr std::array<std::string_view, 6> k_common = {"lp",        "log_prior", "log_constraint",
                                                      "satisfied", "lineage",   "acceptance_rate"};

const archive::DatasetSpec& dataset_of(const archive::Source& source, std::string_view group,
                                       std::string_view name) {
  const archive::Group* found = archive::find_group(source, group);
  const archive::DatasetSpec* spec =
      found == nullptr ? nullptr : archive::find_dataset(*found, name);
  if (spec == nullptr) {
    throw base::Error(
        base::ExitCode::bad_archive,
        fmt::format("{}: missing dataset {}", source.name(), archive::path_of(group, name)));
  }
  return *spec;
}

[[noreturn]] void refuse(const archive::Source& source, std::string_view group,
                         std::string_view dataset, std::string_view reason) {
  throw base::Error(
      base::ExitCode::bad_archive,
      fmt::format("{}: {}: {}", source.name(), archive::path_of(group, dataset), reason));
}

}  // namespace

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

std::uint64_t stats_size(const archive::Source& source, std::string_view dimension) {
  return archive::element_count(dataset_of(source, archive::k_sample_stats, dimension));
}

void check_series(const archive::Source& source, std::string_view variable) {
  const archive::DatasetSpec& spec = dataset_of(source, archive::k_sample_stats, variable);
  if (spec.type == archive::ElementType::text || spec.dims.size() != 2 ||
      spec.dims[0].size != stats_size(source, "chain") ||
      spec.dims[1].size != stats_size(source, "draw")) {
    refuse(source, archive::k_sample_stats, variable, "expected one number per chain and draw");
  }
}

void check_chain(const archive::Source& source, std::uint64_t chain) {
  const std::uint64_t chains = stats_size(source, "chain");
  if (chain < chains) return;
  throw base::Error(base::ExitCode::usage,
                    fmt::format("{}: no chain {}; the archive has {} chains, numbered from 0",
                                source.name(), chain, chains));
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

std::vector<double> read_rows(const archive::Source& source, std::string_view group,
                              std::string_view dataset, std::uint64_t columns, const Rows& rows) {
  const archive::DatasetSpec& spec = dataset_of(source, group, dataset);
  const auto inner = std::span(spec.dims).subspan(std::min<std::size_t>(1, spec.dims.size()));
  std::uint64_t held_columns = spec.dims.empty() ? 0 : 1;
  for (const archive::Dimension& dim : inner)  // saturates instead of overflowing
    held_columns = std::min(held_columns * std::min(dim.size, columns + 1), columns + 1);
  if (held_columns != columns || spec.type == archive::ElementType::text) {
    refuse(source, group, dataset, fmt::format("expected rows of {} numbers", columns));
  }
  const std::uint64_t held = spec.dims[0].size;
  if (rows.first > held || rows.count > held - rows.first) {
    refuse(source, group, dataset,
           fmt::format("the dataset has only {} rows; expected {} rows from row {}", held,
                       rows.count, rows.first));
  }
  return as_doubles(source.read(group, dataset, rows.first * columns, rows.count * columns));
}

}  // namespace sleight::analysis
