#include "clients/cli/main_dice_scene.h"

#include <variant>

#include "common/request/world_parameters.h"
#include "worker/worlds/dice/parameters.h"
#include "worker/worlds/dice/request.h"

namespace sleight::programs {
namespace {

namespace dice = worlds::dice;
constexpr double k_mm_per_m = 1000;

plot::Point mm_of(const math::Vec2& place_m) {
  return {k_mm_per_m * place_m.x(), k_mm_per_m * place_m.y()};
}

}  // namespace

base::Result<cli::DiceScene, std::string> read_dice_scene(std::string_view request_text) {
  const auto parameters = request::world_parameters(request_text, &dice::request_binding);
  if (!parameters) return parameters.error();
  cli::DiceScene scene{.dice = parameters.value().world.dice.size(),
                       .side_mm = k_mm_per_m * parameters.value().world.side_m,
                       .spacing_mm = k_mm_per_m * parameters.value().world.table.spacing_m};
  for (const dice::Goal& goal : parameters.value().goals) {
    if (const auto* place = std::get_if<dice::Place>(&goal.wanted)) {
      scene.places.push_back({.die = goal.die,
                              .centre_mm = mm_of(place->centre_m),
                              .tolerance_mm = k_mm_per_m * goal.tolerance});
    } else if (const auto* region = std::get_if<dice::Region>(&goal.wanted)) {
      scene.regions.push_back(
          {.die = goal.die, .low_mm = mm_of(region->low_m), .high_mm = mm_of(region->high_m)});
    }
  }
  return scene;
}

}  // namespace sleight::programs
