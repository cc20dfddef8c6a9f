// Random tables for tests of boxes on surfaces, and dice above the tables. Control points can be
// changed one by one.
//
// Thread safety: values and pure functions.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "tests/unit/worker/physics/simulator/dice.h"
#include "worker/physics/scene/scene.h"
#include "worker/physics/shape/mass_properties.h"
#include "worker/physics/shape/shapes.h"
#include "worker/physics/surface/surface_controls.h"

namespace sleight::physics::testing {

/// Control points. A function gives every point that hasn't been changed.
class TableControls final : public SurfaceControls {
 public:
  using Function = std::function<SurfaceControl(GridIndex)>;
  using Changes = std::map<GridIndex, SurfaceControl>;
  explicit TableControls(std::shared_ptr<const Function> function, Changes changes = {})
      : function_(std::move(function)), changes_(std::move(changes)) {}

  SurfaceControl at(GridIndex index) const override {
    const auto changed = changes_.find(index);
    return changed != changes_.end() ? changed->second : (*function_)(index);
  }
  std::optional<std::vector<GridIndex>> changed_from(const SurfaceControls& before) const override {
    const auto* other = dynamic_cast<const TableControls*>(&before);
    if (other == nullptr || other->function_ != function_) return std::nullopt;
    std::vector<GridIndex> differ;
    const auto look = [&](const Changes& some) {
      for (const auto& [index, control] : some) {
        if (at(index) != other->at(index)) differ.push_back(index);
      }
    };
    look(changes_);
    look(other->changes_);
    return differ;
  }
  std::shared_ptr<const TableControls> with(GridIndex index, const SurfaceControl& control) const {
    Changes changes = changes_;
    changes[index] = control;
    return std::make_shared<const TableControls>(function_, std::move(changes));
  }

 private:
  std::shared_ptr<const Function> function_;
  Changes changes_;
};

inline std::shared_ptr<const TableControls> table_of(TableControls::Function function) {
  return std::make_shared<const TableControls>(
      std::make_shared<const TableControls::Function>(std::move(function)));
}

/// Shape of a random table. Pits have sharp hollows and gentle bumps; hills have gentle hollows and
/// sharp bumps.
enum class Relief : std::uint8_t { rough, pits, hills, waves, flat };
inline constexpr int k_reliefs = 5;

/// An infinite table. Heights are within +-height_m; restitution and friction are from 0 to 1.
inline std::shared_ptr<const TableControls> random_table(std::uint64_t seed, Relief relief,
                                                         double height_m) {
  return table_of([seed, relief, height_m](GridIndex index) {
    const auto i = static_cast<std::uint64_t>(static_cast<std::uint32_t>(index.i));
    const auto j = static_cast<std::uint64_t>(static_cast<std::uint32_t>(index.j));
    Dice dice(seed, i << 32U | j);
    SurfaceControl control;
    const double share = dice.within(1);
    switch (relief) {
      case Relief::rough:
        control.height_m = height_m * share;
        break;
      case Relief::pits:
        control.height_m = share < -0.7 ? -height_m : 0;
        break;
      case Relief::hills:
        control.height_m = share < -0.7 ? height_m : 0;
        break;
      case Relief::waves:
        control.height_m = height_m * std::sin(0.6 * index.i + static_cast<double>(seed % 7)) *
                           std::cos(0.4 * index.j);
        break;
      case Relief::flat:
        break;
    }
    control.restitution = 0.5 + dice.within(0.5);
    control.friction = 0.5 + dice.within(0.5);
    return control;
  });
}

inline StaticSurface table_surface(std::shared_ptr<const SurfaceControls> controls,
                                   double spacing_m, double point_spacing_m = 4e-3) {
  return {.name = "table",
          .controls = std::move(controls),
          .spacing_m = spacing_m,
          .point_spacing_m = point_spacing_m};
}

/// A body's shape, and its inertia at the density of resin.
inline BodyShape solid_of(ConvexPolyhedron polyhedron, InertiaSymmetry symmetry) {
  return in_body_frame(std::vector{std::move(polyhedron)}, 1200, symmetry).value();
}
inline BodyShape die_of(double side_m) {
  return solid_of(cube(side_m).value(), InertiaSymmetry::spherical);
}

inline Quat random_turn(Dice& dice) {
  return math::quaternion_of_rotation_vector(dice.vector_within(3));
}

/// Dice thrown onto a table. The dice start so close together that they meet.
inline Scene thrown_dice(std::uint64_t seed, std::uint32_t count, StaticSurface surface,
                         double side_m = 0.016) {
  Dice dice(seed, 1);
  Scene scene;
  scene.gravity_mps2 = {0, 0, -9.81};
  scene.slow = slow_contacts_of(side_m, 9.81);
  scene.contacts = ContactTable(1, {.restitution = 0.5, .friction = 0.3});
  scene.surfaces.push_back(std::move(surface));
  const BodyShape die = die_of(side_m);
  const auto shape = std::make_shared<const Compound>(Compound{.parts = die.parts});
  for (std::uint32_t i = 0; i < count; ++i) {
    const double apart_m = 2 * side_m;
    const Vec3 place_m(apart_m * (i % 2) + dice.within(1e-3),
                       apart_m * ((i / 2) % 2) + dice.within(1e-3), 0.03 + apart_m * (i / 4));
    scene.bodies.push_back({.name = {},
                            .shape = shape,
                            .inertia = die.inertia,
                            .start = {.pose = {place_m, math::normalized(random_turn(dice))},
                                      .twist = {dice.vector_within(0.4), dice.vector_within(20)}}});
  }
  return scene;
}

}  // namespace sleight::physics::testing
