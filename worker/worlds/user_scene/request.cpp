#include "worker/worlds/user_scene/request.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <limits>
#include <memory>
#include <optional>
#include <set>
#include <string_view>
#include <utility>

#include "common/request/settled.h"
#include "common/request/text.h"
#include "worker/worlds/user_scene/build.h"
#include "worker/worlds/user_scene/request_parts.h"

namespace sleight::worlds::user_scene {
namespace {

using request::Binder;

/// Binds the law of a material or of a pair. If a pair omits a key, the number in `law` is
/// unchanged.
void bind_law(Binder& table, bool is_pair, physics::SurfaceLaw& law) {
  const auto bind = [&](const char* key, double& value, double maximum, const char* help) {
    if (!is_pair) return table.number(key, value, {.minimum = 0, .maximum = maximum, .help = help});
    table.optional_number(
        key, value,
        {.minimum = 0, .maximum = maximum, .help = "default: the mean of both materials' values"});
  };
  bind("restitution", law.restitution, 1, "coefficient of restitution");
  bind("friction", law.friction, k_friction_max, "Coulomb's coefficient of friction");
  bind("rolling_friction", law.rolling_friction, 1,
       "deceleration of a rolling sphere, divided by the acceleration that presses it down");
}

/// Binds a pair of names. Returns whether the file has two known ones.
bool bind_pair(Binder& table, const char* key, const NameList& names, const char* help,
               std::array<std::uint32_t, 2>& pair) {
  std::vector<std::string> two;
  table.texts(key, two, {.count_min = 2, .count_max = 2, .required = true}, a_name(help));
  for (std::size_t i = 0; i < two.size() && table.valid(key); ++i)
    pair[i] = names.find(table, key, two[i]);
  return !two.empty() && table.valid(key);
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
        bind_law(table, false, material.law);
        names.materials.add(table, "name", material.name);
      });
  if (scene.materials.empty())
    scene.materials.push_back({.name = names.materials.all()[names.materials.number("default")]});

  std::set<std::pair<std::uint32_t, std::uint32_t>> pairs;
  world.tables<PairLaw>(
      "contact", scene.pairs,
      {.count_max = k_materials_max * k_materials_max,
       .help = "laws between two materials; default: the mean of both materials' values"},
      [&](Binder& table, PairLaw& pair) {
        const bool is_known =
            bind_pair(table, "materials", names.materials,
                      "names of the two materials, which may be the same", pair.materials);
        const auto& [a, b] = pair.materials;
        if (is_known) pair.law = mean_law(scene.materials[a].law, scene.materials[b].law);
        bind_law(table, true, pair.law);
        if (is_known && !pairs.emplace(std::minmax(a, b)).second)
          table.error("materials", "another [[world.contact]] already has this pair");
      });
}

void bind_filters(Binder& world, SceneDescription& scene, const Names& names) {
  world.tables<std::array<std::uint32_t, 2>>(
      "no_contact", scene.no_contact,
      {.count_max = k_groups_max * k_groups_max, .help = "pairs of groups that never collide"},
      [&](Binder& table, std::array<std::uint32_t, 2>& pair) {
        bind_pair(table, "groups", names.groups,
                  "names of the two groups; the same name twice: members of the group pass through "
                  "each other",
                  pair);
      });
}

void bind_slow_contacts(Binder& world, SceneDescription& scene) {
  const auto bind = [&](const char* key, std::optional<double>& value, double minimum,
                        const char* unit, const char* help) {
    world.optional_number(key, value,
                          {.minimum = minimum, .maximum = 100, .unit = unit, .help = help});
  };
  bind("separation_mps", scene.separation_speed_mps, 0, "m/s",
       "minimum speed of a bounce; 0: bounces never end; default: follows from the smallest body");
  bind("rest_mps", scene.rest_speed_mps, 0, "m/s",
       "speed below which a body comes to rest; 0: bodies never rest; default: follows from the "
       "smallest body");
  bind("rest_s", scene.rest_time_s, 1e-6, "s",
       "time for which a body must be below rest_mps; default: follows from the smallest body");
}

void bind_noise(Binder& world, physics::ContactNoise& noise) {
  world.table("contact_noise", noise, "random normals and restitution of impacts; default: none",
              [](Binder& table, physics::ContactNoise& given) {
                table.required_number("above_mps", given.above_mps,
                                      {.minimum = 1e-6,
                                       .maximum = 1000,
                                       .unit = "m/s",
                                       .help = "speed of approach above which an impact has noise; "
                                               "its strength is full at twice this speed"});
                table.angle_deg("tilt_sd_deg", given.tilt_sd_rad,
                                {.minimum = 0,
                                 .maximum = 20,
                                 .unit = "deg",
                                 .help = "standard deviation of the normal's tilt in each of two "
                                         "directions"});
                table.number("restitution_sd", given.restitution_sd,
                             {.minimum = 0,
                              .maximum = 1,
                              .help = "standard deviation of the coefficient of restitution"});
              });
}

void bind_scene(Binder& world, SceneDescription& scene, Names& names) {
  world.number("end_s", scene.end_s, in_s("time at which a simulation ends, at the latest", 0.001));
  world.numbers("gravity_mps2", scene.gravity_mps2,
                {.minimum = -1000,
                 .maximum = 1000,
                 .unit = "m/s2",
                 .help = "gravitational acceleration: x, y, z"});
  bind_slow_contacts(world, scene);
  bind_materials(world, scene, names);
  bind_bodies(world, scene, names);
  bind_filters(world, scene, names);
  bind_noise(world, scene.noise);
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
  bind_uncertain(sections.world, names.materials, parameters);
  bind_constraints(sections, parameters);
}

/// A chain that relaxes a find makes as many proposals for each uncertain value.
constexpr std::uint32_t k_relax_scans = 2;
constexpr std::uint32_t k_relax_iterations = 10;
constexpr std::uint32_t k_iterations_max = 100;

void serve_best(request::WorldSections& sections, request::SamplerParameters& sampler,
                const request::StopRule& stop, Parameters& parameters) {
  request::Settled settled(sections.sampler, sampler);
  std::size_t draws = 1;
  if (parameters.built)
    draws = Quantities(parameters.scene, *parameters.built, parameters.uncertain).draws().size();
  const auto iterations = [draws = static_cast<std::uint32_t>(draws)](std::uint32_t for_each) {
    return std::min(k_iterations_max, for_each * std::max(1U, draws));
  };
  if (stop.takes) return settled.relax(iterations(k_relax_iterations), k_relax_scans);
  if (stop.odds) return settled.method(request::Method::splitting, "splitting");
  settled.method(request::Method::parallel_tempering, "parallel_tempering");
  settled.search();
  settled.chains(2, 20, iterations(1));
}

}  // namespace

request::WorldBinding request_binding() {
  request::WorldBinding binding = request::bind_world<Parameters>(
      "scene", "bodies of your own move and end as requested", &bind, &serve_best);
  binding.has_islands = false;
  binding.has_splitting = true;
  return binding;
}

}  // namespace sleight::worlds::user_scene
