#include "worker/worlds/user_scene/state.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/random/linear_distributions.h"
#include "common/random/stream.h"

namespace sleight::worlds::user_scene {
namespace {

using physics::NoiseAddress;
using physics::NoiseValue;

constexpr random::Normal k_standard{.mean = 0, .sd = 1};

NoiseValue drawn(std::uint64_t key, const NoiseAddress& address) {
  // The scene's limits keep bodies and objects below 2^20.
  const std::uint32_t partner = (address.higher & ~physics::k_static) |
                                ((address.higher & physics::k_static) != 0 ? 1U << 20U : 0U);
  random::Stream stream({.seed = key, .chain = {address.lower}, .purpose = random::Purpose::noise},
                        std::uint64_t{partner} << 32U | address.number);
  NoiseValue value;
  for (double& part : value)
    part = k_standard.draw(stream);
  return value;
}

class Values final : public physics::NoiseValues {
 public:
  explicit Values(NoiseState noise) : noise_(std::move(noise)) {}
  NoiseValue at(const NoiseAddress& address) const override { return noise_.at(address); }

 private:
  NoiseState noise_;
};

}  // namespace

NoiseValue NoiseState::at(const NoiseAddress& address) const {
  const auto found = std::ranges::lower_bound(overrides, address, {}, &NoiseOverride::address);
  if (found != overrides.end() && found->address == address) return found->value;
  return drawn(key, address);
}

void NoiseState::set(const NoiseAddress& address, const NoiseValue& value) {
  const auto place = std::ranges::lower_bound(overrides, address, {}, &NoiseOverride::address);
  if (place != overrides.end() && place->address == address) {
    place->value = value;
  } else {
    overrides.insert(place, {address, value});
  }
}

double NoiseState::log_density() const {
  double log = 0;
  for (const NoiseOverride& one : overrides) {
    for (const double part : one.value)
      log += k_standard.log_density(part);
  }
  return log;
}

NoiseState NoiseState::with_key(std::uint64_t new_key,
                                std::span<const physics::Impact> kept) const {
  NoiseState noise{.key = new_key};
  noise.overrides.reserve(kept.size());
  for (const physics::Impact& impact : kept)
    noise.overrides.push_back({address_of(impact), at(address_of(impact))});
  std::ranges::sort(noise.overrides, {}, &NoiseOverride::address);
  return noise;
}

std::shared_ptr<const physics::NoiseValues> values_of(const NoiseState& noise) {
  return std::make_shared<const Values>(noise);
}

base::Bytes encode(const State& state, bool has_noise) {
  base::ByteWriter writer;
  for (const double number : state.numbers)
    writer.put(number);
  if (!has_noise) {
    if (state.numbers.empty()) writer.put(std::uint8_t{0});  // Stored states aren't empty.
    return writer.take();
  }
  writer.put(state.noise.key);
  writer.put(std::uint64_t{state.noise.overrides.size()});
  for (const NoiseOverride& one : state.noise.overrides) {
    writer.put(one.address.lower);
    writer.put(one.address.higher);
    writer.put(one.address.number);
    for (const double part : one.value)
      writer.put(part);
  }
  return writer.take();
}

std::optional<State> decode(const Quantities& quantities, bool has_noise, base::BytesView bytes) {
  base::ByteReader reader(bytes);
  bool good = true;
  const auto next = [&]<class T>(T absent) {
    const std::optional<T> value = reader.get<T>();
    good = good && value.has_value();
    return value.value_or(absent);
  };
  State state;
  for (std::size_t i = 0; good && i < quantities.size(); ++i) {
    const double number = next(0.0);
    good = good && std::isfinite(number) && (quantities.is_normal(i) || (number > 0 && number < 1));
    state.numbers.push_back(number);
  }
  if (!has_noise && state.numbers.empty()) good = good && next(std::uint8_t{1}) == 0;
  if (has_noise) {
    state.noise.key = next(std::uint64_t{0});
    const std::uint64_t overrides = next(std::uint64_t{0});
    for (std::uint64_t nth = 0; good && nth < overrides; ++nth) {
      NoiseOverride one;
      one.address.lower = next(std::uint32_t{0});
      one.address.higher = next(std::uint32_t{0});
      one.address.number = next(std::uint32_t{0});
      for (double& part : one.value) {
        part = next(0.0);
        good = good && std::isfinite(part);
      }
      good = good && (nth == 0 || state.noise.overrides.back().address < one.address);
      state.noise.overrides.push_back(one);
    }
  }
  if (!good || !reader.at_end()) return std::nullopt;
  return state;
}

}  // namespace sleight::worlds::user_scene
