#include "worker/worlds/readers/readers.h"

#include <cmath>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "common/math/elementary.h"
#include "common/scene/surface.h"
#include "worker/worlds/dice/dice.h"
#include "worker/worlds/readers/places_reader.h"
#include "worker/worlds/scene_parts/scene_parts.h"
#include "worker/worlds/segments/recorded_segments.h"

namespace sleight::worlds::dice {
namespace {

constexpr double k_likeness_every_s = 1.0 / 60;
constexpr const char* k_table_name = "table";
/// Distance from a unit cube's centre to a corner.
constexpr double k_half_diagonal = 0.8661;

void append_vector(const Vec3& v, std::vector<double>& values) {
  values.insert(values.end(), {v.x(), v.y(), v.z()});
}

std::vector<double> components(const WorldParameters& world, Vec3 DieStart::*vector) {
  std::vector<double> values;
  for (const DieStart& die : world.dice)
    append_vector(die.*vector, values);
  return values;
}

std::vector<archive::Variable> variables_of(const Dice& world) {
  const WorldParameters& parameters = world.parameters().world;
  const archive::Dimension die{.name = "die", .size = world.dice()};
  const archive::Dimension xyz{.name = "axis_xyz", .size = 3};
  const archive::Dimension quaternion{.name = "quaternion_wxyz", .size = 4};
  const archive::Dimension half{.name = "half", .size = 2};
  return {{.name = "table_key",
           .dims = {half},
           .meaning = "upper and lower 32 bits of the key that generates the table"},
          {.name = "changed_points",
           .meaning = "number of control points that differ from those that the key generates"},
          {.name = "start_position_m",
           .dims = {die, xyz},
           .unit = "m",
           .meaning = "the die's centre at release",
           .prior_mean = components(parameters, &DieStart::position_m),
           .prior_sd = components(parameters, &DieStart::position_sd_m)},
          {.name = "start_orientation",
           .dims = {die, quaternion},
           .meaning = "rotation at release, from the unnumbered cube's frame to the table's"},
          {.name = "start_velocity_mps",
           .dims = {die, xyz},
           .unit = "m s-1",
           .meaning = "velocity of the die's centre at release",
           .prior_mean = components(parameters, &DieStart::velocity_mps),
           .prior_sd = components(parameters, &DieStart::velocity_sd_mps)},
          {.name = "start_spin_radps",
           .dims = {die, xyz},
           .unit = "rad s-1",
           .meaning = "angular velocity at release, in the table's frame",
           .prior_mean = components(parameters, &DieStart::spin_radps),
           .prior_sd = components(parameters, &DieStart::spin_sd_radps)}};
}

std::vector<archive::Variable> outcomes_of(const Parameters& parameters) {
  std::vector<archive::Variable> outcomes{
      {.name = "end",
       .meaning = "why the simulation ended: 0 all dice at rest, 1 time limit, 2 no room to start, "
                  "or the simulator failed"},
      {.name = "end_s", .unit = "s", .meaning = "time at which the last die came to rest"},
      {.name = "collisions", .meaning = "number of collisions of dice with the table"},
      {.name = "log_plausibility",
       .meaning = "log p_w of the control points on which the dice's collisions depended"},
      {.name = "offset_squares",
       .meaning = "sum of the squared heights of these control points, in standard deviations"},
      {.name = "offsets",
       .dims = {{.name = "offset_bin", .size = k_offset_bins}},
       .meaning = fmt::format("histogram of the heights of these control points, in standard "
                              "deviations; bins: below {}, steps of {}, above the last step",
                              k_offset_first_sd, k_offset_step_sd)}};
  for (std::size_t i = 0; i < parameters.goals.size(); ++i) {
    const Goal& goal = parameters.goals[i];
    const std::string unit = unit_of(goal);
    outcomes.push_back({.name = fmt::format("goal_{}_{}_{}", i + 1, name_of(goal), unit),
                        .unit = unit == "mps" ? "m s-1" : unit,
                        .meaning = fmt::format("distance of die {} from this goal", goal.die + 1)});
  }
  return outcomes;
}

archive::WorldLayout make_layout(const Dice& world) {
  archive::WorldLayout layout{.world = "dice",
                              .variables = variables_of(world),
                              .outcomes = outcomes_of(world.parameters()),
                              .proposal_kinds = {"change_all", "change_die", "change_start",
                                                 "change_control", "change_contact"}};
  if (world.parameters().numbering == Numbering::free) {
    for (std::uint32_t die = 0; die < world.dice(); ++die) {
      layout.log_natural_throw +=
          math::log(double{k_numberings} / numberings_that_meet(world.parameters().goals, die));
    }
  }
  return layout;
}

/// Returns a die's goals, as if it were the first die.
std::vector<Goal> goals_of(std::span<const Goal> goals, std::uint32_t die) {
  std::vector<Goal> own;
  for (const Goal& goal : goals) {
    if (goal.die != die) continue;
    own.push_back(goal);
    own.back().die = 0;
  }
  return own;
}

void add_goal(scene::Scene& scene, const Goal& goal, std::size_t number) {
  add_feature(scene, scene::FeatureKind::wanted,
              fmt::format("goal {}: {} of die {}", number, name_of(goal), goal.die + 1));
  scene.features.back().body = static_cast<std::int32_t>(goal.die);
  if (const auto* place = std::get_if<Place>(&goal.wanted)) {
    add_part(scene, scene::Shape::disc, {2 * goal.tolerance, 2 * goal.tolerance, 0},
             {place->centre_m.x(), place->centre_m.y(), 0});
  } else if (const auto* region = std::get_if<Region>(&goal.wanted)) {
    const Vec2 sides_m = region->high_m - region->low_m;
    const Vec2 middle_m = 0.5 * (region->high_m + region->low_m);
    add_part(scene, scene::Shape::box, {sides_m.x(), sides_m.y(), 0},
             {middle_m.x(), middle_m.y(), 0});
  }
}

/// Sets a view that contains the starts, half a second of flight, and the goals.
void set_view(scene::Scene& scene, const WorldParameters& world) {
  constexpr double k_sds = 3;
  constexpr double k_ahead_s = 0.5;
  scene.low_m = {-2 * world.side_m, -2 * world.side_m, -world.side_m};
  scene.high_m = {2 * world.side_m, 2 * world.side_m, 2 * world.side_m};
  const auto hold = [&scene](const Vec3& low_m, const Vec3& high_m) {
    scene.low_m = scene.low_m.cwiseMin(low_m);
    scene.high_m = scene.high_m.cwiseMax(high_m);
  };
  for (const DieStart& die : world.dice) {
    const Vec3 around_m = k_sds * die.position_sd_m + Vec3::Constant(world.side_m);
    hold(die.position_m - around_m, die.position_m + around_m);
    Vec3 ahead_m = die.position_m + k_ahead_s * die.velocity_mps;
    ahead_m.z() = 0;
    hold(ahead_m, ahead_m);
  }
  for (const scene::Part& part : scene.parts) {
    if (scene.features[part.feature].kind == scene::FeatureKind::wanted)
      hold(part.position_m - 0.5 * part.size_m, part.position_m + 0.5 * part.size_m);
  }
}

scene::Scene make_scene(const Parameters& parameters) {
  const WorldParameters& world = parameters.world;
  scene::Scene scene;
  for (std::uint32_t die = 0; die < world.dice.size(); ++die) {
    add_feature(scene, scene::FeatureKind::body, fmt::format("die {}", die + 1));
    add_part(scene, scene::Shape::die, Vec3::Constant(world.side_m));
    // Dice with the same goals look alike.
    std::uint32_t& twin = scene.features.back().twin_of;
    for (twin = 0; goals_of(parameters.goals, twin) != goals_of(parameters.goals, die);)
      ++twin;
  }
  add_feature(scene, scene::FeatureKind::fixed, k_table_name);
  const TableParameters& table = world.table;
  add_part(scene, scene::Shape::surface,
           {table.spacing_m * table.columns, table.spacing_m * table.rows, table.spacing_m});
  for (std::size_t i = 0; i < parameters.goals.size(); ++i)
    add_goal(scene, parameters.goals[i], i + 1);
  scene.has_own_points = true;
  set_view(scene, world);
  return scene;
}

class DiceReader final : public PlacesReader<Dice> {
 public:
  explicit DiceReader(const Dice& world)
      : PlacesReader(
            world, make_layout(world), make_scene(world.parameters()),
            {.diameters_m = std::vector<double>(world.dice(), world.parameters().world.side_m),
             .step = physics::ticks_after(k_likeness_every_s)}),
        table_(static_cast<std::int32_t>(scene().find(k_table_name).value())) {}

  /// The table's control points near places where dice touch the table.
  scene::Variation variation(base::BytesView bytes,
                             std::span<const motion::Segment> segments) const override {
    const State state = decoded(world(), bytes);
    const WorldParameters& parameters = world().parameters().world;
    std::vector<Vec3> touches_m;
    for (const motion::Segment& segment : segments) {
      if (segment.partner == table_ || segment.mode == motion::Mode::resting)
        touches_m.push_back(segment.position_m);
    }
    scene::Variation own;
    for (const auto& [i, j] : scene::indices_about(touches_m, k_half_diagonal * parameters.side_m,
                                                   parameters.table.spacing_m)) {
      const SurfaceControl control = control_at(parameters, state, {i, j});
      own.points.push_back({.i = i,
                            .j = j,
                            .height_m = control.height_m,
                            .restitution = control.restitution,
                            .friction = control.friction});
    }
    return own;
  }

 private:
  std::vector<motion::Segment> segments_of(const Animation& animation) const override {
    std::vector<RecordedBody> dice;
    for (const auto& numbering : animation.outcome.judgement.numberings)
      dice.push_back({.feature = static_cast<std::uint32_t>(dice.size()),
                      .frame = {.orientation = rotation_of_numbering(numbering)}});
    return recorded_segments(animation.recording, dice,
                             [this](std::uint32_t, std::uint32_t) { return table_; });
  }

  std::vector<double> values_of(const State& state) const override {
    std::vector<double> values{static_cast<double>(state.table_key >> 32U),
                               static_cast<double>(state.table_key & 0xffffffffU),
                               static_cast<double>(state.overrides.size())};
    for (const DieThrow& die : state.dice)
      append_vector(die.position_m, values);
    for (const DieThrow& die : state.dice)
      values.insert(values.end(), {die.orientation.w(), die.orientation.x(), die.orientation.y(),
                                   die.orientation.z()});
    for (const DieThrow& die : state.dice)
      append_vector(die.velocity_mps, values);
    for (const DieThrow& die : state.dice)
      append_vector(die.spin_radps, values);
    return values;
  }

  std::int32_t table_;  ///< number of the table's scene feature
};

}  // namespace

std::unique_ptr<archive::StateReader> make_state_reader(const Parameters& parameters) {
  return std::make_unique<DiceReader>(Dice(parameters));
}

}  // namespace sleight::worlds::dice
