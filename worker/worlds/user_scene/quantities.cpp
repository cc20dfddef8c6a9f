#include "worker/worlds/user_scene/quantities.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "common/base/check.h"
#include "common/math/elementary.h"
#include "common/math/normal_quantile.h"
#include "common/random/linear_distributions.h"
#include "worker/worlds/user_scene/body_form.h"

namespace sleight::worlds::user_scene {
namespace {

constexpr double k_value_max = 1e3;  ///< in SI units
constexpr std::array<QuantityKind, k_quantities> k_quantity_kinds{{
    {Quantity::position, "position_mm", 3, k_m_per_mm, -k_value_max, k_value_max},
    {Quantity::velocity, "velocity_mps", 3, 1, -k_value_max, k_value_max},
    {Quantity::spin, "spin_radps", 3, 1, -k_value_max, k_value_max},
    {Quantity::turn, "turn_deg", 3, k_rad_per_deg, -k_value_max, k_value_max},
    {Quantity::orientation, "orientation", 4, 1, -1, 1},
    {Quantity::start, "start_s", 1, 1, 0, 3600},
    {Quantity::presence, "presence", 1, 1, 0, 1},
    {Quantity::radius, "radius_mm", 1, k_m_per_mm, 1e-5, k_value_max},
    {Quantity::size, "size_mm", 3, k_m_per_mm, 1e-5, k_value_max},
    {Quantity::density, "density_kgpm3", 1, 1, 0.001, 1e6, true},
    {Quantity::restitution, "restitution", 1, 1, 0, 1, true},
    {Quantity::friction, "friction", 1, 1, 0, 100, true},
    {Quantity::rolling_friction, "rolling_friction", 1, 1, 0, 1, true},
}};

constexpr random::Normal k_standard{.mean = 0, .sd = 1};

/// Quantile of the standard normal restricted to [-bound, bound]. Exactly odd about u = 1/2.
double truncated_quantile(double u, double bound) {
  if (u > 0.5) return -truncated_quantile(1 - u, bound);
  const double below = 0.5 * math::erfc(bound / std::numbers::sqrt2);
  return std::max(-bound, math::normal_quantile(below + u * (1 - 2 * below)));
}

std::size_t chosen(std::span<const double> shares, double u) {
  std::size_t choice = 0;
  for (double sum = shares[0]; u >= sum && choice + 1 < shares.size(); sum += shares[choice])
    ++choice;
  return choice;
}

bool is_random(const Uncertain& one, std::size_t component) {
  return one.sd[component] > 0 || one.within[component] > 0;
}

/// Returns a quantity of a material.
auto& value_of(auto& material, Quantity quantity) {
  switch (quantity) {
    case Quantity::density:
      return material.density_kgpm3;
    case Quantity::restitution:
      return material.law.restitution;
    case Quantity::friction:
      return material.law.friction;
    default:
      return material.law.rolling_friction;
  }
}

Vec3 xyz_of(const std::array<double, 4>& values) {
  return {values[0], values[1], values[2]};
}

}  // namespace

const QuantityKind& kind_of(Quantity quantity) {
  return k_quantity_kinds[static_cast<std::size_t>(quantity)];
}
std::span<const QuantityKind> all_quantities() {
  return k_quantity_kinds;
}

Quantities::Quantities(const SceneDescription& scene, const BuiltScene& built,
                       std::span<const Uncertain> uncertain)
    : scene_(scene), built_(built), uncertain_(uncertain), of_bodies_(built.moving) {
  for (std::uint32_t i = 0; i < uncertain.size(); ++i) {
    const Uncertain& one = uncertain[i];
    const QuantityKind& kind = kind_of(one.quantity);
    const std::span<const std::uint32_t> all(one.targets);
    const std::size_t together = one.shared ? all.size() : 1;
    for (std::size_t first = 0; first < all.size(); first += together) {
      Draw draw{.uncertain = i,
                .targets = all.subspan(first, together),
                .first_number = is_normal_.size()};
      if (one.quantity == Quantity::orientation) {
        is_normal_.insert(is_normal_.end(), 4, true);
      } else if (one.quantity == Quantity::presence || !one.choices.empty()) {
        is_normal_.push_back(false);
      } else {
        for (std::size_t component = 0; component < kind.width; ++component) {
          if (is_random(one, component)) is_normal_.push_back(!(one.within[component] > 0));
        }
      }
      draw.numbers = is_normal_.size() - draw.first_number;
      for (const std::uint32_t target : draw.targets) {
        if (!kind.of_material) of_bodies_[target].push_back(draws_.size());
      }
      draws_.push_back(draw);
    }
  }
}

Numbers Quantities::draw_prior(random::Stream& stream) const {
  Numbers numbers;
  for (std::size_t i = 0; i < size(); ++i)
    numbers.push_back(is_normal_[i] ? k_standard.draw(stream) : stream.uniform());
  return numbers;
}

std::vector<double> Quantities::log_densities(const Numbers& numbers) const {
  std::vector<double> logs(uncertain_.size(), 0);
  for (const Draw& draw : draws_) {
    for (std::size_t i = draw.first_number; i < draw.first_number + draw.numbers; ++i)
      if (is_normal_[i]) logs[draw.uncertain] += k_standard.log_density(numbers[i]);
  }
  return logs;
}

double Quantities::log_density(const Numbers& numbers) const {
  CHECK_EQ(numbers.size(), size());
  double sum = 0;
  for (std::size_t i = 0; i < size(); ++i)
    if (is_normal_[i]) sum += k_standard.log_density(numbers[i]);
  return sum;
}

double Quantities::nominal(Quantity quantity, std::uint32_t target, std::size_t component) const {
  const auto axis = static_cast<Eigen::Index>(component);
  if (kind_of(quantity).of_material) return value_of(scene_.materials[target], quantity);
  const Object& object = built_.objects[target];
  const BodyDescription& body = scene_.bodies[object.description];
  switch (quantity) {
    case Quantity::position:
      return object.place.position_m[axis];
    case Quantity::velocity:
      return object.motion.velocity_mps[axis];
    case Quantity::spin:
      return object.motion.angular_velocity_radps[axis];
    case Quantity::start:
      return body.start_s;
    case Quantity::radius:
      return body.sizes.radius_m;
    case Quantity::size:
      return body.sizes.size_m[axis];
    default:
      return 0;
  }
}

Quantities::Values Quantities::values_of(const Draw& draw, std::uint32_t target,
                                         const Numbers& numbers) const {
  const Uncertain& one = of(draw);
  const QuantityKind& kind = kind_of(one.quantity);
  std::size_t next = draw.first_number;
  Values values{};
  if (one.quantity == Quantity::orientation) {
    const Quat drawn(numbers[next], numbers[next + 1], numbers[next + 2], numbers[next + 3]);
    // The zero quaternion has probability 0.
    const Quat unit = drawn.coeffs().isZero() ? Quat::Identity() : math::normalized(drawn);
    return {unit.w(), unit.x(), unit.y(), unit.z()};
  }
  if (one.quantity == Quantity::presence) return {numbers[next] < one.probability ? 1.0 : 0.0};
  if (!one.choices.empty()) {
    std::ranges::copy(one.choices[chosen(one.shares, numbers[next])], values.begin());
    return values;
  }
  for (std::size_t component = 0; component < kind.width; ++component) {
    double value = nominal(one.quantity, target, component);
    if (is_random(one, component)) {
      const double number = numbers[next++];
      const double sd = one.sd[component];
      const double within = one.within[component];
      value += within == 0 ? sd * number
               : sd == 0   ? within * (2 * number - 1)
                           : sd * truncated_quantile(number, within / sd);
    }
    values[component] = std::clamp(value, kind.minimum, kind.maximum);
  }
  return values;
}

std::vector<double> Quantities::values(const Numbers& numbers) const {
  std::vector<double> all;
  for (const Draw& draw : draws_) {
    const Values values = values_of(draw, draw.targets.front(), numbers);
    const QuantityKind& kind = kind_of(of(draw).quantity);
    for (std::size_t component = 0; component < kind.width; ++component)
      all.push_back(values[component] / kind.scale);
  }
  return all;
}

std::vector<std::string> Quantities::value_names() const {
  std::vector<std::string> names;
  for (const Draw& draw : draws_) {
    const Uncertain& one = of(draw);
    const QuantityKind& kind = kind_of(one.quantity);
    const std::uint32_t target = draw.targets.front();
    std::string name = one.name;
    if (!one.shared && one.targets.size() > 1) {
      name += ": ";
      name += kind.of_material ? scene_.materials[target].name : built_.objects[target].name;
    }
    const std::string_view axes = kind.width == 4 ? "wxyz" : "xyz";
    for (std::size_t component = 0; component < kind.width; ++component)
      names.push_back(kind.width == 1 ? name : fmt::format("{} {}", name, axes[component]));
  }
  return names;
}

std::vector<std::array<double, 2>> Quantities::normal_values() const {
  constexpr double k_none = std::numeric_limits<double>::quiet_NaN();
  std::vector<std::array<double, 2>> all;
  for (const Draw& draw : draws_) {
    const Uncertain& one = of(draw);
    const QuantityKind& kind = kind_of(one.quantity);
    for (std::size_t component = 0; component < kind.width; ++component) {
      const bool is_normal = one.sd[component] > 0 && one.within[component] == 0;
      const double mean = nominal(one.quantity, draw.targets.front(), component);
      all.push_back(is_normal ? std::array{mean / kind.scale, one.sd[component] / kind.scale}
                              : std::array{k_none, k_none});
    }
  }
  return all;
}

bool Quantities::change_body(std::uint32_t number, const Numbers& numbers,
                             physics::Scene& scene) const {
  Object object = built_.objects[number];
  const BodyDescription& described = scene_.bodies[object.description];
  ShapeSizes sizes = described.sizes;
  bool is_resized = false;
  physics::BodyDescription& body = scene.bodies[number];
  for (const std::size_t index : of_bodies_[number]) {
    const Draw& draw = draws_[index];
    const Values values = values_of(draw, number, numbers);
    switch (of(draw).quantity) {
      case Quantity::position:
        object.place.position_m = xyz_of(values);
        break;
      case Quantity::velocity:
        object.motion.velocity_mps = xyz_of(values);
        break;
      case Quantity::spin:
        object.motion.angular_velocity_radps = xyz_of(values);
        break;
      case Quantity::turn:
        object.place.orientation = math::normalized(math::composed(
            math::quaternion_of_rotation_vector(xyz_of(values)), object.place.orientation));
        break;
      case Quantity::orientation:
        object.place.orientation = Quat(values[0], values[1], values[2], values[3]);
        break;
      case Quantity::start:
        body.start_tick = physics::Tick{} + physics::ticks_after(values[0]);
        break;
      case Quantity::presence:
        if (values[0] == 0) body.start_tick = physics::k_tick_max;
        break;
      case Quantity::radius:
        sizes.radius_m = values[0];
        is_resized = true;
        break;
      default:
        sizes.size_m = xyz_of(values);
        is_resized = true;
        break;
    }
  }
  if (is_resized) {
    const auto form = body_form(sizes, {}, scene_.materials[described.material].density_kgpm3);
    if (!form) return false;
    body.shape = form.value().shape(sizes);
    body.inertia = form.value().inertia;
    if (described.mass_kg) body.inertia = with_mass(body.inertia, *described.mass_kg);
  }
  body.start = start_of(object);
  return true;
}

void Quantities::change_materials(const Numbers& numbers, physics::Scene& scene) const {
  std::vector<Material> materials = scene_.materials;
  bool changed = false;
  for (const Draw& draw : draws_) {
    const Quantity quantity = of(draw).quantity;
    if (!kind_of(quantity).of_material) continue;
    changed = true;
    for (const std::uint32_t target : draw.targets)
      value_of(materials[target], quantity) = values_of(draw, target, numbers)[0];
  }
  if (!changed) return;
  scene.contacts = contact_table(materials, scene_.pairs);
  for (std::uint32_t body = 0; body < built_.moving; ++body) {
    const BodyDescription& described = scene_.bodies[built_.objects[body].description];
    const double ratio = materials[described.material].density_kgpm3 /
                         scene_.materials[described.material].density_kgpm3;
    physics::Inertia& inertia = scene.bodies[body].inertia;
    if (!described.mass_kg && ratio != 1) inertia = with_mass(inertia, ratio * inertia.mass_kg);
  }
}

std::optional<physics::Scene> Quantities::scene(const Numbers& numbers) const {
  CHECK_EQ(numbers.size(), size());
  physics::Scene scene = built_.scene;
  for (std::uint32_t body = 0; body < built_.moving; ++body)
    if (!of_bodies_[body].empty() && !change_body(body, numbers, scene)) return std::nullopt;
  change_materials(numbers, scene);
  return scene;
}

bool Quantities::resemble(const Numbers& a, const Numbers& b) const {
  const auto is_same = [&](const Draw& draw) {
    const auto first = static_cast<std::ptrdiff_t>(draw.first_number);
    return std::equal(a.begin() + first,
                      a.begin() + first + static_cast<std::ptrdiff_t>(draw.numbers),
                      b.begin() + first);
  };
  for (const Draw& draw : draws_)
    if (kind_of(of(draw).quantity).of_material && !is_same(draw)) return false;
  return std::ranges::any_of(of_bodies_, [&](const std::vector<std::size_t>& draws) {
    return std::ranges::all_of(draws, [&](std::size_t draw) { return is_same(draws_[draw]); });
  });
}

}  // namespace sleight::worlds::user_scene
