#include "worker/worlds/spelling/landing_map.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <span>

#include "common/base/check.h"

namespace sleight::worlds::spelling {
namespace {

constexpr std::uint32_t k_side = Landings::k_side;

std::optional<std::size_t> cell_of(const Vec2& displacement_m, double cell_m) {
  const double column = std::floor(displacement_m.x() / cell_m) + k_side / 2;
  const double row = std::floor(displacement_m.y() / cell_m) + k_side / 2;
  if (!(column >= 0 && column < k_side && row >= 0 && row < k_side)) return std::nullopt;
  return static_cast<std::size_t>(row) * k_side + static_cast<std::size_t>(column);
}

std::array<Vec2, 8> mirrored(const Vec2& d) {
  return {Vec2(d.x(), d.y()), Vec2(-d.x(), d.y()), Vec2(d.x(), -d.y()), Vec2(-d.x(), -d.y()),
          Vec2(d.y(), d.x()), Vec2(-d.y(), d.x()), Vec2(d.y(), -d.x()), Vec2(-d.y(), -d.x())};
}

}  // namespace

void Landings::add(const Vec2& displacement_m) {
  for (const Vec2& image_m : mirrored(displacement_m)) {
    const auto cell = cell_of(image_m, pitch_m_ / k_cells);
    if (!cell) continue;
    ++counts_[*cell];
    ++total_;
  }
}

void Landings::add(const Landings& other) {
  CHECK_EQ(pitch_m_, other.pitch_m_);
  for (std::size_t cell = 0; cell < counts_.size(); ++cell)
    counts_[cell] += other.counts_[cell];
  total_ += other.total_;
  failures_.insert(failures_.end(), other.failures_.begin(), other.failures_.end());
}

Landings landings_of_batch(const Spelling& world, std::uint64_t seed, std::uint64_t batch) {
  random::Stream stream({.seed = seed, .purpose = random::Purpose::guide}, batch);
  const State box = world.draw_prior(stream);
  Landings landings(world.bins().pitch_m());
  for (std::uint32_t ball = 0; ball < k_landings_of_batch; ++ball) {
    const Vec2 drop_m = world.prior().draw_drop(stream);
    const Spelling::Alone alone = world.fall_alone(box.offsets_m, drop_m);
    if (alone.failure != nullptr) landings.add_failure(alone.failure);
    if (alone.bin == k_fills_none) continue;
    landings.add(drop_m - world.middle_m(static_cast<std::size_t>(alone.bin)));
  }
  return landings;
}

Landings landings_of(const Spelling& world, std::uint64_t seed, std::uint64_t batches) {
  Landings all(world.bins().pitch_m());
  for (std::uint64_t batch = 0; batch < batches; ++batch)
    all.add(landings_of_batch(world, seed, batch));
  return all;
}

LandingMap::LandingMap(const Landings& landings) : cell_m_(landings.pitch_m() / Landings::k_cells) {
  constexpr std::size_t k_all = std::size_t{k_side} * k_side;
  double sum = 0;
  for (std::size_t cell = 0; cell < k_all; ++cell) {
    const double share = landings.total() == 0 ? 1.0 / k_all
                                               : static_cast<double>(landings.count(cell)) /
                                                     static_cast<double>(landings.total());
    shares_.push_back(share);
    cumulative_.push_back(sum += share);
  }
  cumulative_.back() = 1;
}

Vec2 LandingMap::draw(random::Stream& stream) const {
  const double u = stream.uniform();
  const auto found = std::upper_bound(cumulative_.begin(), cumulative_.end(), u);
  const auto cell = static_cast<std::size_t>(found - cumulative_.begin());
  const double x = static_cast<double>(cell % k_side) - k_side / 2 + stream.uniform();
  const double y = static_cast<double>(cell / k_side) - k_side / 2 + stream.uniform();
  return {cell_m_ * x, cell_m_ * y};
}

double LandingMap::density(const Vec2& displacement_m) const {
  const auto cell = cell_of(displacement_m, cell_m_);
  return cell ? shares_[*cell] / (cell_m_ * cell_m_) : 0;
}

Vec2 BinDrops::draw(std::size_t bin, random::Stream& stream) const {
  if (stream.uniform() < k_window_share) return world_->windows().draw(bin, stream);
  return world_->middle_m(bin) + map_->draw(stream);
}

double BinDrops::density(std::size_t bin, const Vec2& drop_m) const {
  return k_window_share * world_->windows().density(std::span(&bin, 1), drop_m) +
         (1 - k_window_share) * map_->density(drop_m - world_->middle_m(bin));
}

}  // namespace sleight::worlds::spelling
