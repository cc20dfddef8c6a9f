#include "clients/analysis/scalar_draws.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/archive/format.h"
#include "common/base/check.h"
#include "common/base/error.h"

namespace sleight::analysis {
namespace {

constexpr std::uint64_t k_read_values = 65536;

const archive::DatasetSpec& spec_of(const archive::Source& source, const Quantity& quantity,
                                    const DrawRange& range) {
  const archive::Group* group = archive::find_group(source, quantity.group);
  const archive::DatasetSpec* spec =
      group == nullptr ? nullptr : archive::find_dataset(*group, quantity.name);
  const std::uint64_t end =
      range.count == 0 ? 0 : range.first + (range.count - 1) * range.stride + 1;
  if (spec == nullptr || spec->type != archive::ElementType::f64 ||
      spec->dims.size() != 2 + quantity.inner.size() || spec->dims[0].size < range.chains ||
      spec->dims[1].size < end ||
      !std::equal(quantity.inner.begin(), quantity.inner.end(), spec->dims.begin() + 2,
                  [](const auto& a, const auto& b) { return a.size == b.size; })) {
    throw base::Error(base::ExitCode::bad_archive,
                      fmt::format("{}: {}: expected one number per chain and draw", source.name(),
                                  archive::path_of(quantity.group, quantity.name)));
  }
  return *spec;
}

struct Block {
  std::uint64_t first = 0;
  std::uint64_t count = 0;
};

/// Returns `chains` * `count` values for each scalar of a block.
std::vector<std::vector<double>> read_block(const archive::Source& source, const Quantity& quantity,
                                            const Block& block, const DrawRange& range) {
  const std::uint64_t row = quantity.entries();
  const std::uint64_t draws = spec_of(source, quantity, range).dims[1].size;
  std::vector<std::vector<double>> scalars(block.count);
  for (std::vector<double>& scalar : scalars)
    scalar.reserve(range.chains * range.count);
  // Read rows together if they are close. Otherwise, read only the block's part of each row.
  const std::uint64_t step = row * range.stride;
  const std::uint64_t together = step > archive::k_batch_elements ? 1 : k_read_values / step;
  for (std::uint64_t chain = 0; chain < range.chains; ++chain) {
    for (std::uint64_t done = 0; done < range.count; done += together) {
      const std::uint64_t rows = std::min(together, range.count - done);
      const std::uint64_t draw = range.first + done * range.stride;
      const archive::Values values =
          source.read(quantity.group, quantity.name, (chain * draws + draw) * row + block.first,
                      (rows - 1) * step + block.count);
      const auto& numbers = std::get<std::vector<double>>(values);
      for (std::uint64_t r = 0; r < rows; ++r) {
        for (std::uint64_t e = 0; e < block.count; ++e)
          scalars[e].push_back(numbers[r * step + e]);
      }
    }
  }
  return scalars;
}

}  // namespace

DrawRange bounded_range(std::uint64_t chains, std::uint64_t first, std::uint64_t available,
                        std::uint64_t scalars) {
  CHECK(chains >= 1 && chains <= k_chains_max);
  CHECK_GE(scalars, 1U);
  const std::uint64_t least = std::max(k_scalar_draws_min, k_chain_draws_min * chains);
  const std::uint64_t most = std::clamp(k_all_draws_max / scalars, least, k_scalar_draws_max);
  const std::uint64_t of_chain = most / chains;
  DrawRange range{.chains = chains, .first = first};
  if (available == 0) return range;
  range.stride = (available - 1) / of_chain + 1;
  range.count = (available - 1) / range.stride + 1;
  return range;
}

std::uint64_t scalars_max(const DrawRange& range) {
  return k_all_draws_max / std::max(range.chains * range.count, std::uint64_t{1024});
}

std::uint64_t Quantity::entries() const {
  std::uint64_t product = 1;
  for (const archive::Dimension& dim : inner)
    product *= dim.size;
  return product;
}

std::string Quantity::entry_name(std::uint64_t entry) const {
  if (inner.empty()) return name;
  std::vector<std::uint64_t> indices(inner.size());
  for (std::size_t d = inner.size(); d-- > 0;) {
    indices[d] = entry % inner[d].size;
    entry /= inner[d].size;
  }
  return fmt::format("{}[{}]", name, fmt::join(indices, ", "));
}

std::vector<Quantity> state_variables(const archive::Source& source) {
  std::vector<Quantity> variables;
  const archive::Group* posterior = archive::find_group(source, archive::k_posterior);
  if (posterior == nullptr) return variables;
  for (const archive::DatasetSpec& spec : posterior->datasets) {
    if (spec.dims.size() < 2 || spec.type != archive::ElementType::f64) continue;
    if (spec.dims[0].name != "chain" || spec.dims[1].name != "draw") continue;
    variables.push_back({.group = archive::k_posterior,
                         .name = spec.name,
                         .inner = {spec.dims.begin() + 2, spec.dims.end()}});
  }
  return variables;
}

void for_each_scalar(
    const archive::Source& source, const Quantity& quantity, std::uint64_t entries,
    const DrawRange& range,
    const std::function<void(std::uint64_t entry, std::vector<double>& values)>& visit) {
  const std::uint64_t each = std::max(range.chains * range.count, std::uint64_t{1});
  const std::uint64_t together = std::max(k_block_draws_max / each, std::uint64_t{1});
  for (std::uint64_t first = 0; first < entries; first += together) {
    const Block block{first, std::min(together, entries - first)};
    std::vector<std::vector<double>> scalars = read_block(source, quantity, block, range);
    for (std::uint64_t e = 0; e < block.count; ++e)
      visit(first + e, scalars[e]);
  }
}

StandIns with_stand_in(std::span<double> values) {
  const auto needs_one = [](double value) {
    return std::isnan(value) || value == -std::numeric_limits<double>::infinity();
  };
  StandIns found;
  double least = std::numeric_limits<double>::infinity();
  double greatest = -std::numeric_limits<double>::infinity();
  for (const double value : values) {
    if (std::isnan(value)) {
      ++found.nan;
    } else if (needs_one(value)) {
      ++found.minus_infinite;
    } else {
      least = std::min(least, value);
      greatest = std::max(greatest, value);
    }
  }
  const bool none_finite = least > greatest;
  // Choose a value further from the median than any finite value.
  const double below =
      none_finite ? 0 : least - 2 * (greatest - least) - std::max(1.0, std::fabs(least));
  for (double& value : values) {
    if (needs_one(value)) value = below;
  }
  return found;
}

}  // namespace sleight::analysis
