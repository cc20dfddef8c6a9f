#include "clients/cli/main_scenes.h"

#include <array>
#include <variant>

#include "common/request/world_parameters.h"
#include "worker/worlds/dice/dice.h"
#include "worker/worlds/dice/parameters.h"
#include "worker/worlds/dice/request.h"
#include "worker/worlds/spelling/parameters.h"
#include "worker/worlds/spelling/request.h"

namespace sleight::programs {
namespace {

namespace dice = worlds::dice;
constexpr double k_mm_per_m = 1000;

plot::Point mm_of(const math::Vec2& place_m) {
  return {k_mm_per_m * place_m.x(), k_mm_per_m * place_m.y()};
}

/// The random components of one vector of a die's start.
void add_components(const std::string& variable, const std::string& name, std::uint64_t die,
                    const math::Vec3& mean, const math::Vec3& sd, cli::DicePrior& prior) {
  constexpr std::array k_axes{"x", "y", "z"};
  for (std::size_t axis = 0; axis < k_axes.size(); ++axis) {
    const auto at = static_cast<Eigen::Index>(axis);
    if (sd[at] <= 0) continue;
    prior.start.push_back({.variable = variable,
                           .name = name + " " + k_axes[axis],
                           .die = die,
                           .axis = axis,
                           .mean = mean[at],
                           .sd = sd[at]});
  }
}

}  // namespace

base::Result<cli::DicePrior, std::string> read_dice_prior(std::string_view request_text) {
  const auto parameters = request::world_parameters(request_text, &dice::request_binding);
  if (!parameters) return parameters.error();
  const dice::WorldParameters& world = parameters.value().world;
  cli::DicePrior prior{.dice = world.dice.size(),
                       .is_table_random = world.table.height_sd_m > 0,
                       .offset_bins = dice::k_offset_bins,
                       .offset_first_sd = dice::k_offset_first_sd,
                       .offset_step_sd = dice::k_offset_step_sd,
                       .bin_of = dice::offset_bin_of};
  for (std::size_t die = 0; die < world.dice.size(); ++die) {
    const dice::DieStart& start = world.dice[die];
    add_components("start_position_m", "position", die, start.position_m, start.position_sd_m,
                   prior);
    add_components("start_velocity_mps", "velocity", die, start.velocity_mps, start.velocity_sd_mps,
                   prior);
    add_components("start_spin_radps", "spin", die, start.spin_radps, start.spin_sd_radps, prior);
  }
  return prior;
}

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

base::Result<cli::SpellingBox, std::string> read_spelling_box(std::string_view request_text) {
  const auto parameters =
      request::world_parameters(request_text, &worlds::spelling::request_binding);
  if (!parameters) return parameters.error();
  const worlds::spelling::WorldParameters& world = parameters.value().world;
  const worlds::spelling::Pattern& pattern = parameters.value().pattern;
  return cli::SpellingBox{
      .columns = pattern.columns,
      .rows = pattern.rows,
      .designated = std::vector<bool>(pattern.designated.begin(), pattern.designated.end()),
      .bin_mm = k_mm_per_m * world.bin_m,
      .partition_mm = k_mm_per_m * world.partition_m,
      .partition_height_mm = k_mm_per_m * world.partition_height_m,
      .box_height_mm = k_mm_per_m * world.box_height_m,
      .drop_height_mm = k_mm_per_m * world.drop_height_m,
      .ball_diameter_mm = k_mm_per_m * world.ball_diameter_m};
}

}  // namespace sleight::programs
