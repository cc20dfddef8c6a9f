#include "worker/worlds/dice/random_table.h"

#include <algorithm>
#include <utility>

#include "common/base/check.h"
#include "common/random/distributions.h"

namespace sleight::worlds::dice {
namespace {

double draw_from(const Range& range, random::Stream& stream) {
  if (range.is_constant()) return range.low;
  return random::Uniform{.low = range.low, .high = range.high}.draw(stream);
}

double log_density_of(const Range& range, double x) {
  if (range.is_constant()) return x == range.low ? 0 : k_impossible;
  return random::Uniform{.low = range.low, .high = range.high}.log_density(x);
}

}  // namespace

GridIndex first_of(const TableParameters& table) {
  return {-static_cast<std::int32_t>(table.columns / 2),
          -static_cast<std::int32_t>(table.rows / 2)};
}

GridIndex last_of(const TableParameters& table) {
  const GridIndex first = first_of(table);
  return {first.i + static_cast<std::int32_t>(table.columns) - 1,
          first.j + static_cast<std::int32_t>(table.rows) - 1};
}

bool is_on_table(const TableParameters& table, GridIndex index) {
  const GridIndex first = first_of(table);
  const GridIndex last = last_of(table);
  return index.i >= first.i && index.i <= last.i && index.j >= first.j && index.j <= last.j;
}

SurfaceControl control_of_key(const TableParameters& table, std::uint64_t key, GridIndex index) {
  if (!is_on_table(table, index)) {
    return {
        .height_m = 0, .restitution = table.restitution.mean(), .friction = table.friction.mean()};
  }
  const std::uint64_t place = std::uint64_t{static_cast<std::uint32_t>(index.i)} << 32U |
                              static_cast<std::uint32_t>(index.j);
  random::Stream stream({.seed = key, .purpose = random::Purpose::table}, place);
  SurfaceControl control;
  if (table.height_sd_m > 0)
    control.height_m = random::Normal{.mean = 0, .sd = table.height_sd_m}.draw(stream);
  control.restitution = draw_from(table.restitution, stream);
  control.friction = draw_from(table.friction, stream);
  return control;
}

double log_density_of(const TableParameters& table, const SurfaceControl& control) {
  double sum = control.height_m == 0 ? 0 : k_impossible;
  if (table.height_sd_m > 0)
    sum = random::Normal{.mean = 0, .sd = table.height_sd_m}.log_density(control.height_m);
  return sum + log_density_of(table.restitution, control.restitution) +
         log_density_of(table.friction, control.friction);
}

const Override* find_override(const Overrides& overrides, GridIndex index) {
  const auto found = std::ranges::lower_bound(overrides, index, {}, &Override::index);
  return found == overrides.end() || found->index != index ? nullptr : &*found;
}

void set_override(Overrides& overrides, const Override& one) {
  const auto found = std::ranges::lower_bound(overrides, one.index, {}, &Override::index);
  if (found != overrides.end() && found->index == one.index) {
    found->control = one.control;
  } else {
    overrides.insert(found, one);
  }
}

std::vector<GridIndex> differences(const Overrides& a, const Overrides& b) {
  std::vector<GridIndex> places;
  auto left = a.begin();
  auto right = b.begin();
  while (left != a.end() || right != b.end()) {
    if (right == b.end() || (left != a.end() && left->index < right->index)) {
      places.push_back((left++)->index);
    } else if (left == a.end() || right->index < left->index) {
      places.push_back((right++)->index);
    } else {
      if (!(left->control == right->control)) places.push_back(left->index);
      ++left;
      ++right;
    }
  }
  return places;
}

RandomTable::RandomTable(const TableParameters& table, std::uint64_t key, Overrides overrides)
    : table_(table), key_(key), overrides_(std::move(overrides)) {
  for (std::size_t i = 0; i < overrides_.size(); ++i) {
    CHECK(is_on_table(table_, overrides_[i].index));
    CHECK(i == 0 || overrides_[i - 1].index < overrides_[i].index);
  }
}

SurfaceControl RandomTable::at(GridIndex index) const {
  const Override* found = find_override(overrides_, index);
  return found != nullptr ? found->control : control_of_key(table_, key_, index);
}

std::optional<std::vector<GridIndex>> RandomTable::changed_from(
    const SurfaceControls& before) const {
  const auto* other = dynamic_cast<const RandomTable*>(&before);
  if (other == nullptr || other->key_ != key_ || other->table_ != table_) return std::nullopt;
  return differences(other->overrides_, overrides_);
}

}  // namespace sleight::worlds::dice
