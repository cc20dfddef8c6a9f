#include "worker/worlds/readers/readers.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "worker/physics/motion/segment.h"
#include "worker/worlds/readers/places_reader.h"
#include "worker/worlds/user_scene/look/look.h"
#include "worker/worlds/user_scene/user_scene.h"

namespace sleight::worlds::user_scene {
namespace {

constexpr double k_likeness_every_s = 1.0 / 30;

/// Returns a dimension with these names, made shorter and distinct as archives need it.
archive::Dimension dimension_of(const char* dimension, const std::vector<std::string>& names) {
  constexpr std::size_t k_bytes_max = archive::k_index_name_bytes_max - 8;
  archive::Dimension made{.name = dimension, .size = names.size()};
  std::map<std::string, int> uses;
  for (std::string name : names) {
    const auto begins_character = [&](std::size_t i) { return (name[i] & 0xc0) != 0x80; };
    std::size_t bytes = std::min(name.size(), k_bytes_max);
    while (bytes < name.size() && !begins_character(bytes))
      --bytes;
    name.resize(bytes);
    while (++uses[name] > 1)
      name += fmt::format(" {}", uses[name]);
    made.names.push_back(name);
  }
  return made;
}

template <class Entries>
std::vector<std::string> names_of(const Entries& entries) {
  std::vector<std::string> names;
  for (const auto& entry : entries)
    names.push_back(entry.name);
  return names;
}

archive::WorldLayout make_layout(const UserScene& world) {
  const Parameters& parameters = world.parameters();
  archive::WorldLayout layout{
      .world = "scene",
      .variables = {},
      .outcomes = {{.name = "end",
                    .meaning = "how the simulation ended: 0 all bodies rest or have left, or no "
                               "constraint waits for this, 1 at the time limit, 2 it can't start "
                               "(for example, bodies overlap), 3 the simulator failed"},
                   {.name = "end_s", .unit = "s", .meaning = "end of the simulation"},
                   {.name = "collisions", .meaning = "number of collisions"}},
      .proposal_kinds = {"redraw_all", "redraw_body", "redraw_quantity", "step_all", "step_body",
                         "step_quantity", "shot", "tail"}};
  layout.proposal_kinds.resize(world.proposal_kinds());
  if (world.quantities().size() == 0 && !world.has_noise())
    layout.warning = "nothing is uncertain, so all animations are the same";
  if (world.has_noise()) {
    layout.outcomes.push_back(
        {.name = "normals", .meaning = "standard normals that the simulation used"});
    layout.outcomes.push_back(
        {.name = "squares",
         .meaning = "sum of their squares; the chi-square tail tells how plausible they are"});
  }
  const std::vector<std::string> names = world.quantities().value_names();
  if (!names.empty()) {
    archive::Variable value{.name = "value",
                            .dims = {dimension_of("quantity", names)},
                            .meaning = "uncertain values, in the units that their names end with"};
    for (const auto& [mean, sd] : world.quantities().normal_values()) {
      value.prior_mean.push_back(mean);
      value.prior_sd.push_back(sd);
    }
    layout.variables = {std::move(value),
                        {.name = "log_prior_of",
                         .dims = {dimension_of("uncertain", names_of(parameters.uncertain))},
                         .meaning = "log p_w of the random numbers of each [[world.uncertain]]"}};
  }
  if (!parameters.constraints.empty())
    layout.outcomes.push_back(
        {.name = "distance",
         .dims = {dimension_of("constraint", names_of(parameters.constraints))},
         .meaning = "distance from each constraint: m, rad, s or bodies"});
  return layout;
}

/// Bodies are interchangeable if they are copies with equal constraints and uncertain values.
void set_twins(const Parameters& parameters, scene::Scene& scene) {
  std::map<std::string, std::uint32_t> first_with;
  for (std::uint32_t body = 0; body < parameters.built->moving; ++body) {
    std::string sort = std::to_string(parameters.built->objects[body].description);
    for (const Constraint& one : parameters.constraints) {
      const bool names_it = std::ranges::count(one.bodies, body) > 0;
      const bool is_hit = std::ranges::count(one.hits, body) > 0;
      if (names_it || is_hit) sort += (names_it ? " line " : " hit ") + std::to_string(one.line);
    }
    for (std::size_t i = 0; i < parameters.uncertain.size(); ++i) {
      const Uncertain& one = parameters.uncertain[i];
      if (!kind_of(one.quantity).of_material && std::ranges::count(one.targets, body) > 0)
        sort += " draw " + std::to_string(i);
    }
    scene.features[body].twin_of = first_with.emplace(sort, body).first->second;
  }
}

/// Extends the view by the motion of a typical draw, but not by what falls far.
void extend_view(const UserScene& world, scene::Scene& scene) {
  State typical;
  for (std::size_t i = 0; i < world.quantities().size(); ++i)
    typical.numbers.push_back(world.quantities().is_normal(i) ? 0 : 0.5);
  const Animation animation = world.animate(typical);
  const Vec3 far_m = 2 * Vec3::Constant((scene.high_m - scene.low_m).maxCoeff());
  const Vec3 low_m = scene.low_m - far_m;
  const Vec3 high_m = scene.high_m + far_m;
  for (std::uint32_t body = 0; body < animation.recording.bodies(); ++body) {
    const Vec3 reach_m =
        Vec3::Constant(physics::reach_m(world.parameters().built->scene.bodies[body].shape));
    for (const physics::Recording::Entry& entry : animation.recording.segments({body})) {
      const Vec3 place_m = physics::position_at(entry.segment.flight, entry.segment.flight.begin);
      scene.low_m = scene.low_m.cwiseMin((place_m - reach_m).cwiseMax(low_m));
      scene.high_m = scene.high_m.cwiseMax((place_m + reach_m).cwiseMin(high_m));
    }
  }
}

scene::Scene make_scene(const UserScene& world) {
  const Parameters& parameters = world.parameters();
  scene::Scene scene = look_of(parameters);
  set_twins(parameters, scene);
  extend_view(world, scene);
  return scene;
}

PlacesLikeness make_likeness(const BuiltScene& built) {
  PlacesLikeness likeness{.diameters_m = {}, .step = physics::ticks_after(k_likeness_every_s)};
  for (std::uint32_t body = 0; body < built.moving; ++body)
    likeness.diameters_m.push_back(2 * physics::reach_m(built.scene.bodies[body].shape));
  return likeness;
}

class SceneReader final : public PlacesReader<UserScene> {
 public:
  explicit SceneReader(const UserScene& world)
      : PlacesReader(world, make_layout(world), make_scene(world),
                     make_likeness(*world.parameters().built)) {}

 private:
  std::vector<motion::Segment> segments_of(const Animation& animation) const override {
    return user_scene::segments_of(*world().parameters().built, animation.recording);
  }

  std::vector<double> values_of(const State& state) const override {
    std::vector<double> values = world().quantities().values(state.numbers);
    if (values.empty()) return {};
    const std::vector<double> logs = world().quantities().log_densities(state.numbers);
    values.insert(values.end(), logs.begin(), logs.end());
    return values;
  }
};

}  // namespace

std::unique_ptr<archive::StateReader> make_state_reader(const Parameters& parameters) {
  return std::make_unique<SceneReader>(UserScene(parameters));
}

}  // namespace sleight::worlds::user_scene
