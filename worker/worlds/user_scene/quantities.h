// What is uncertain in a scene.
//
// A state is a vector of independent random numbers: standard normal z, and u uniform on (0, 1). An
// Uncertain is one [[world.uncertain]]. It has a draw for each of its targets, or one draw for all
// of them. A draw has numbers of the state. Its values, in SI units, are functions of the numbers:
//
//   normal            nominal + sd z
//   uniform           nominal + within (2 u - 1)
//   truncated normal  nominal + sd q(u); q is the quantile function of the standard normal
//                     restricted to [-within/sd, within/sd]
//   choice            the choice whose share of (0, 1) contains u
//   orientation       four normals, scaled to a unit quaternion: uniform
//   presence          the body takes part if u is below the probability
//
// A component whose sd and within are 0 has its nominal value and no number. The nominal value of a
// turn is no turn; any other nominal value is the one that the scene describes. A value beyond the
// range of its key is set to the end of the range.
//
// The density of a state is the product of its normals' densities, so it is normalised. A move that
// leaves the numbers' distribution invariant leaves p_w invariant.
// Thread safety: const functions may be called from several threads at once.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/random/stream.h"
#include "worker/worlds/user_scene/build.h"
#include "worker/worlds/user_scene/description.h"

namespace sleight::worlds::user_scene {

inline constexpr double k_m_per_mm = 1e-3;
inline constexpr double k_rad_per_deg = std::numbers::pi / 180;

/// What an Uncertain changes; those from `density` on belong to materials, the others to moving
/// bodies.
enum class Quantity : std::uint8_t {
  position,
  velocity,  ///< of the shape's origin
  spin,
  turn,  ///< a rotation vector in the world's frame, applied to the described orientation
  orientation,
  start,
  presence,
  radius,  ///< of a sphere
  size,    ///< of a box
  density,
  restitution,
  friction,
  rolling_friction,
};
inline constexpr std::size_t k_quantities = 13;

/// Properties of a kind of quantity.
struct QuantityKind {
  Quantity quantity;
  std::string_view key;  ///< its name in requests, with the unit
  std::size_t width;     ///< components of a value
  double scale;          ///< the request's number for 1 in SI units
  double minimum;        ///< range of the values in SI units
  double maximum;
  bool of_material = false;
};
const QuantityKind& kind_of(Quantity quantity);
std::span<const QuantityKind> all_quantities();

struct Uncertain {
  std::string name;
  Quantity quantity = Quantity::position;
  std::vector<std::uint32_t> targets{};  ///< moving bodies in BuiltScene::objects, or materials
  bool shared = false;                   ///< one draw for all targets
  std::vector<double> sd{};              ///< by component; 0: not normal
  std::vector<double> within{};          ///< by component; 0: not bounded
  std::vector<std::vector<double>> choices{};  ///< values
  std::vector<double> shares{};                ///< of the choices; they add up to 1
  double probability = 1;                      ///< of presence
};

/// The numbers of a draw in a state.
struct Draw {
  std::uint32_t uncertain = 0;
  std::span<const std::uint32_t> targets;
  std::size_t first_number = 0;
  std::size_t numbers = 0;
};

using Numbers = std::vector<double>;

class Quantities {
 public:
  /// REQUIRES: all arguments outlive this object; `built` was made from `scene`.
  Quantities(const SceneDescription& scene, const BuiltScene& built,
             std::span<const Uncertain> uncertain);

  std::size_t size() const { return is_normal_.size(); }
  bool is_normal(std::size_t number) const { return is_normal_[number]; }
  std::span<const Draw> draws() const { return draws_; }
  /// By moving body: indices of the draws that have it as a target.
  const std::vector<std::vector<std::size_t>>& draws_of_bodies() const { return of_bodies_; }

  Numbers draw_prior(random::Stream& stream) const;
  double log_density(const Numbers& numbers) const;
  /// Returns each Uncertain's part of the log density.
  std::vector<double> log_densities(const Numbers& numbers) const;

  /// Returns the values of all draws, in the units of their keys. If a draw serves several targets,
  /// the values are those of the first.
  std::vector<double> values(const Numbers& numbers) const;
  /// Returns names such as "die position_mm: die 1 x", in the order of values().
  std::vector<std::string> value_names() const;
  /// Returns the mean and standard deviation of each value that is normal, otherwise NaN and NaN.
  std::vector<std::array<double, 2>> normal_values() const;

  /// Returns the scene with the state's values. Empty if the sizes of a box make no shape, because
  /// the box is too flat.
  std::optional<physics::Scene> scene(const Numbers& numbers) const;
  /// Whether two states may have bodies that start alike in the same scene, so that a replay can
  /// save time.
  bool resemble(const Numbers& a, const Numbers& b) const;

 private:
  using Values = std::array<double, 4>;

  const Uncertain& of(const Draw& draw) const { return uncertain_[draw.uncertain]; }
  double nominal(Quantity quantity, std::uint32_t target, std::size_t component) const;
  /// Returns a draw's values for a target; an orientation has four, w first.
  Values values_of(const Draw& draw, std::uint32_t target, const Numbers& numbers) const;
  /// Returns whether the body has a shape.
  bool change_body(std::uint32_t body, const Numbers& numbers, physics::Scene& scene) const;
  void change_materials(const Numbers& numbers, physics::Scene& scene) const;

  const SceneDescription& scene_;
  const BuiltScene& built_;
  std::span<const Uncertain> uncertain_;
  std::vector<Draw> draws_;
  std::vector<bool> is_normal_;
  std::vector<std::vector<std::size_t>> of_bodies_;
};

}  // namespace sleight::worlds::user_scene
