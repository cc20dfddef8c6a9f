// A state of a scene: the numbers of its uncertain values, and the noise of its impacts.
//
// The noise is a key, and overrides at some addresses (contact_noise.h). The key determines the
// three standard normals of every other address. The density is relative to the values that the
// key draws, so each override adds its log density.
// Thread safety: values and pure functions.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "common/base/bytes.h"
#include "worker/physics/contact/impacts.h"
#include "worker/physics/scene/contact_noise.h"
#include "worker/worlds/user_scene/quantities.h"

namespace sleight::worlds::user_scene {

struct NoiseOverride {
  physics::NoiseAddress address;
  physics::NoiseValue value{};
  friend bool operator==(const NoiseOverride&, const NoiseOverride&) = default;
};

struct NoiseState {
  std::uint64_t key = 0;
  std::vector<NoiseOverride> overrides{};  ///< ascending addresses, without repetition
  friend bool operator==(const NoiseState&, const NoiseState&) = default;

  physics::NoiseValue at(const physics::NoiseAddress& address) const;
  void set(const physics::NoiseAddress& address, const physics::NoiseValue& value);
  double log_density() const;
  /// Returns the noise with a new key, in which the impacts at `kept` keep their values.
  NoiseState with_key(std::uint64_t new_key, std::span<const physics::Impact> kept) const;
};

struct State {
  Numbers numbers;
  NoiseState noise{};  ///< stays as it is if the scene has no noise
  friend bool operator==(const State&, const State&) = default;
};

/// Returns log p_w.
inline double log_density(const Quantities& quantities, const State& state) {
  return quantities.log_density(state.numbers) + state.noise.log_density();
}

/// REQUIRES: the impact is noised.
inline physics::NoiseAddress address_of(const physics::Impact& impact) {
  return {impact.lower, impact.higher, impact.noise_number};
}

/// Returns the noise as the simulator reads it.
std::shared_ptr<const physics::NoiseValues> values_of(const NoiseState& noise);

/// Bytes of a state: its numbers, and, if the scene has noise, the key (u64), the number of
/// overrides (u64), and each override's address (3 u32) and value.
base::Bytes encode(const State& state, bool has_noise);
/// Refuses a wrong length, numbers that aren't finite, uniforms outside (0, 1), and overrides that
/// are out of order.
std::optional<State> decode(const Quantities& quantities, bool has_noise, base::BytesView bytes);

}  // namespace sleight::worlds::user_scene
