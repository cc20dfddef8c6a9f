#include "clients/cli/trace.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <span>
#include <utility>
#include <variant>

#include "common/archive/format.h"
#include "common/base/error.h"

namespace sleight::cli {
namespace {

/// More lines in one panel can't be told apart: the palette has so many colours.
constexpr std::uint64_t k_chains_drawn_max = 6;

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

[[noreturn]] void refuse(const archive::Source& source, std::string_view group,
                         std::string_view dataset, std::string_view reason) {
  throw base::Error(
      base::ExitCode::bad_archive,
      fmt::format("{}: {}: {}", source.name(), archive::path_of(group, dataset), reason));
}

/// Keeps the first, lowest, highest and last point of each stretch of `stretch` points.
class Thinner {
 public:
  explicit Thinner(std::uint64_t stretch) : stretch_(stretch) {}

  void push(const plot::Point& point) {
    if (seen_ == 0) kept_.fill(point);
    ++seen_;
    kept_[k_last] = point;
    if (std::isfinite(point.y)) {
      plot::Point& lowest = kept_[k_lowest];
      plot::Point& highest = kept_[k_highest];
      if (!std::isfinite(lowest.y) || point.y < lowest.y) lowest = point;
      if (!std::isfinite(highest.y) || point.y > highest.y) highest = point;
    }
    if (seen_ == stretch_) end_stretch();
  }

  std::vector<plot::Point> take() {
    if (seen_ > 0) end_stretch();
    return std::move(points_);
  }

 private:
  static constexpr std::size_t k_lowest = 1;
  static constexpr std::size_t k_highest = 2;
  static constexpr std::size_t k_last = 3;

  void end_stretch() {
    std::ranges::sort(kept_, {}, &plot::Point::x);
    for (std::size_t i = 0; i < kept_.size(); ++i) {
      if (i == 0 || kept_[i].x != kept_[i - 1].x) points_.push_back(kept_[i]);
    }
    seen_ = 0;
  }

  std::uint64_t stretch_;
  std::uint64_t seen_ = 0;             ///< of the current stretch
  std::array<plot::Point, 4> kept_{};  ///< of the current stretch: first, lowest, highest, last
  std::vector<plot::Point> points_;
};

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

std::vector<plot::Point> trace(const archive::Source& source, std::string_view variable,
                               const TraceRange& range, double scale) {
  const archive::DatasetSpec& spec = dataset_of(source, archive::k_sample_stats, variable);
  const std::uint64_t chains = stats_size(source, "chain");
  const std::uint64_t draws = stats_size(source, "draw");
  if (spec.type == archive::ElementType::text || spec.dims.size() != 2 ||
      spec.dims[0].size != chains || spec.dims[1].size != draws) {
    refuse(source, archive::k_sample_stats, variable, "it has no number for each chain and draw");
  }
  check_chain(source, range.chain);
  const std::uint64_t count = range.draws == 0 ? draws : std::min(range.draws, draws);
  const std::uint64_t stretches = range.points_max / 4;
  Thinner thinner(count <= range.points_max ? 1 : (count - 1) / stretches + 1);
  for (std::uint64_t first = 0; first < count; first += k_batch) {
    const std::vector<double> values =
        as_doubles(source.read(archive::k_sample_stats, variable, range.chain * draws + first,
                               std::min(k_batch, count - first)));
    for (std::size_t i = 0; i < values.size(); ++i) {
      thinner.push({static_cast<double>(first + i), scale * values[i]});
    }
  }
  return thinner.take();
}

void check_chain(const archive::Source& source, std::uint64_t chain) {
  const std::uint64_t chains = stats_size(source, "chain");
  if (chain < chains) return;
  throw base::Error(base::ExitCode::usage,
                    fmt::format("{}: no chain {}; it has {} chains, counted from 0", source.name(),
                                chain, chains));
}

std::vector<std::uint64_t> chains_to_draw(const archive::Source& source,
                                          std::optional<std::uint64_t> asked) {
  if (asked) {
    check_chain(source, *asked);
    return {*asked};
  }
  std::vector<std::uint64_t> chains(std::min(stats_size(source, "chain"), k_chains_drawn_max));
  std::iota(chains.begin(), chains.end(), std::uint64_t{0});
  return chains;
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
  for (const archive::Dimension& dim : inner)  // more than enough stays so, without overflow
    held_columns = std::min(held_columns * std::min(dim.size, columns + 1), columns + 1);
  const bool fits = held_columns == columns && (columns != 1 || inner.empty());
  if (!fits || spec.type == archive::ElementType::text) {
    refuse(source, group, dataset, fmt::format("expected rows of {} numbers", columns));
  }
  const std::uint64_t held = spec.dims[0].size;
  if (rows.first > held || rows.count > held - rows.first) {
    refuse(source, group, dataset,
           fmt::format("it has {} rows: no {} from row {}", held, rows.count, rows.first));
  }
  return as_doubles(source.read(group, dataset, rows.first * columns, rows.count * columns));
}

}  // namespace sleight::cli
