#include "worker/worlds/user_scene/request.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <limits>
#include <memory>
#include <optional>
#include <string_view>
#include <utility>

#include "common/request/settled.h"
#include "common/request/text.h"
#include "worker/worlds/user_scene/build.h"
#include "worker/worlds/user_scene/request_body.h"
#include "worker/worlds/user_scene/request_constraints.h"
#include "worker/worlds/user_scene/request_uncertain.h"

namespace sleight::worlds::user_scene {
namespace {

using request::Binder;

void bind_law(Binder& table, physics::SurfaceLaw& law) {
  table.number("restitution", law.restitution,
               {.minimum = 0, .maximum = 1, .help = "coefficient of restitution"});
  table.number(
      "friction", law.friction,
      {.minimum = 0, .maximum = k_friction_max, .help = "Coulomb's coefficient of friction"});
  table.number(
      "rolling_friction", law.rolling_friction,
      {.minimum = 0,
       .maximum = 1,
       .help =
           "deceleration of a rolling sphere, divided by the acceleration that presses it down"});
}

/// Like bind_law, but keys that the file omits keep the mean of both materials' values.
void bind_pair_law(Binder& table, physics::SurfaceLaw& law) {
  const auto optional = [&](std::string_view key, double& value, double maximum) {
    std::optional<double> given;
    table.optional_number(
        key, given,
        {.minimum = 0, .maximum = maximum, .help = "default: the mean of both materials' values"});
    if (given) value = *given;
  };
  optional("restitution", law.restitution, 1);
  optional("friction", law.friction, k_friction_max);
  optional("rolling_friction", law.rolling_friction, 1);
}

void bind_materials(Binder& world, SceneDescription& scene, Names& names) {
  world.tables<Material>(
      "material", scene.materials,
      {.count_max = k_materials_max,
       .help = "materials; default: one material with the defaults of these keys"},
      [&](Binder& table, Material& material) {
        table.required_text("name", material.name, a_name("material's name"));
        table.number("density_kgpm3", material.density_kgpm3,
                     {.minimum = 0.001,
                      .maximum = 1e6,
                      .unit = "kg/m3",
                      .help = "density; gives the mass of a body without mass_kg"});
        bind_law(table, material.law);
        names.materials.add(table, "name", material.name);
      });
  if (scene.materials.empty())
    scene.materials.push_back({.name = names.materials.all()[names.materials.number("default")]});

  world.tables<PairLaw>(
      "contact", scene.pairs,
      {.count_max = k_materials_max * k_materials_max,
       .help = "laws between two materials; default: the mean of both materials' values"},
      [&](Binder& table, PairLaw& pair) {
        std::vector<std::string> two;
        table.texts("materials", two, {.count_min = 2, .count_max = 2, .required = true},
                    a_name("names of the two materials, which may be the same"));
        for (std::size_t i = 0; i < two.size() && table.valid("materials"); ++i)
          pair.materials[i] = names.materials.find(table, "materials", two[i]);
        if (table.valid("materials"))
          pair.law = mean_law(scene.materials[pair.materials[0]].law,
                              scene.materials[pair.materials[1]].law);
        bind_pair_law(table, pair.law);
        if (table.line() == 0 || !table.valid("materials")) return;
        auto key = std::minmax(pair.materials[0], pair.materials[1]);
        if (!names.pairs.emplace(key.first, key.second).second)
          table.error("materials", "another [[world.contact]] already has this pair");
      });
}

void bind_filters(Binder& world, SceneDescription& scene, Names& names) {
  world.tables<std::array<std::uint32_t, 2>>(
      "no_contact", scene.no_contact,
      {.count_max = k_groups_max * k_groups_max, .help = "pairs of groups that never collide"},
      [&](Binder& table, std::array<std::uint32_t, 2>& pair) {
        std::vector<std::string> two;
        table.texts("groups", two, {.count_min = 2, .count_max = 2, .required = true},
                    a_name("names of the two groups; the same name twice: members of the group "
                           "pass through each other"));
        for (std::size_t i = 0; i < two.size() && table.valid("groups"); ++i)
          pair[i] = names.groups.find(table, "groups", two[i]);
      });
}

void bind_slow_contacts(Binder& world, SceneDescription& scene) {
  world.optional_number(
      "separation_mps", scene.separation_speed_mps,
      {.minimum = 0,
       .maximum = 100,
       .unit = "m/s",
       .help = "minimum speed of a bounce; 0: bounces never end; default: follows "
               "from the smallest body"});
  world.optional_number("rest_mps", scene.rest_speed_mps,
                        {.minimum = 0,
                         .maximum = 100,
                         .unit = "m/s",
                         .help = "speed below which a body comes to rest; 0: bodies never rest; "
                                 "default: follows from the smallest body"});
  world.optional_number(
      "rest_s", scene.rest_time_s,
      {.minimum = 1e-6,
       .maximum = 100,
       .unit = "s",
       .help = "time for which a body must be below rest_mps; default: follows from "
               "the smallest body"});
}

void bind_scene(Binder& world, SceneDescription& scene, Names& names) {
  world.number("end_s", scene.end_s, in_s("time at which a simulation ends, at the latest", 0.001));
  std::array<double, 3> gravity{0, 0, -9.81};
  world.numbers("gravity_mps2", gravity,
                {.minimum = -1000,
                 .maximum = 1000,
                 .unit = "m/s2",
                 .help = "gravitational acceleration: x, y, z"});
  scene.gravity_mps2 = vector_of(gravity);
  bind_slow_contacts(world, scene);
  bind_materials(world, scene, names);
  bind_bodies(world, scene, names);
  bind_filters(world, scene, names);
  scene.groups = names.groups.all();
}

/// Builds the scene. Null if it has errors.
std::shared_ptr<const BuiltScene> built_of(Binder& world, const SceneDescription& scene) {
  if (world.line() == 0 || !world.is_sound()) return nullptr;
  auto built = build(scene);
  if (built) return std::make_shared<const BuiltScene>(std::move(built).value());
  const auto& [body, error] = built.error();
  world.error("body",
              fmt::format("{} (line {}): '{}': {}", request::toml_string(scene.bodies[body].name),
                          scene.bodies[body].line, error.key, error.message));
  return nullptr;
}

void bind(request::WorldSections& sections, Parameters& parameters) {
  Names names;
  bind_scene(sections.world, parameters.scene, names);
  parameters.built = built_of(sections.world, parameters.scene);
  std::optional<ObjectNames> objects;
  if (parameters.built) objects.emplace(parameters.scene, *parameters.built);
  const ObjectNames* const found = objects ? &*objects : nullptr;
  bind_uncertain(sections.world, parameters, found, names.materials);
  std::vector<NamedRegion> regions;
  bind_regions(sections.world, regions);
  bind_constraints(sections.constraint, parameters, regions, found);
}

/// A chain that relaxes a find makes as many proposals for each uncertain value.
constexpr std::uint32_t k_relax_scans = 2;
constexpr std::uint32_t k_relax_iterations = 10;
constexpr std::uint32_t k_iterations_max = 100;

void serve_best(request::WorldSections& sections, request::SamplerParameters& sampler,
                const request::StopRule& stop, Parameters& parameters) {
  request::Settled settled(sections.sampler);
  std::uint32_t draws = 1;
  if (parameters.built)
    draws = std::max<std::uint32_t>(
        1,
        static_cast<std::uint32_t>(
            Quantities(parameters.scene, *parameters.built, parameters.uncertain).draws().size()));
  if (stop.takes) {
    settled.count("iterations_per_scan", sampler.iterations_per_scan,
                  std::min(k_iterations_max, k_relax_iterations * draws));
    settled.count("relax_scans", sampler.relax_scans, k_relax_scans);
    return;
  }
  sampler.method = request::Method::parallel_tempering;
  settled.word("method", "parallel_tempering");
  sampler.start = request::Start::search;
  settled.word("start", "search");
  settled.count("chains", sampler.chains, 2);
  settled.count("round_scans", sampler.round_scans, 20);
  settled.count("iterations_per_scan", sampler.iterations_per_scan,
                std::min(k_iterations_max, draws));
}

}  // namespace

request::WorldBinding request_binding() {
  request::WorldBinding binding = request::bind_world<Parameters>(
      "scene", "bodies of your own move and end as requested", &bind, &serve_best);
  binding.has_islands = false;
  return binding;
}

}  // namespace sleight::worlds::user_scene
