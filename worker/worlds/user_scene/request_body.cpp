#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>

#include "common/math/elementary.h"
#include "common/request/nearest.h"
#include "common/request/text.h"
#include "worker/worlds/user_scene/body_form.h"
#include "worker/worlds/user_scene/request.h"
#include "worker/worlds/user_scene/request_parts.h"

namespace sleight::worlds::user_scene {
namespace {

using request::Binder;
using request::NumberOptions;

constexpr double k_small_mm = 0.01;
constexpr double k_mm_per_m = 1e3;
/// If a request omits a cylinder's or cone's `edge_mm`: a share of the smaller of radius and
/// length.
constexpr double k_edge_share = 0.02;

constexpr std::array<request::Named<ShapeKind>, k_shape_kinds> k_shape_names{
    {{"sphere", ShapeKind::sphere},
     {"box", ShapeKind::box},
     {"capsule", ShapeKind::capsule},
     {"cylinder", ShapeKind::cylinder},
     {"cone", ShapeKind::cone},
     {"rounded_box", ShapeKind::rounded_box},
     {"pin", ShapeKind::pin},
     {"hull", ShapeKind::hull},
     {"compound", ShapeKind::compound},
     {"plane", ShapeKind::plane},
     {"mesh", ShapeKind::mesh},
     {"helix", ShapeKind::helix},
     {"ramp", ShapeKind::ramp}}};
static_assert(k_shape_kinds == static_cast<std::size_t>(ShapeKind::ramp) + 1);

/// The first shapes may be parts of a compound.
constexpr std::size_t k_part_shapes = static_cast<std::size_t>(ShapeKind::hull) + 1;

/// The keys of sizes. `needed` or `usable` has a bit per kind of shape.
struct SizeKey {
  std::string_view key;
  std::uint32_t needed;
  std::uint32_t usable;
};
constexpr std::uint32_t bits(std::initializer_list<ShapeKind> kinds) {
  std::uint32_t all = 0;
  for (const ShapeKind kind : kinds)
    all |= 1U << static_cast<unsigned>(kind);
  return all;
}
using enum ShapeKind;
constexpr std::array k_size_keys{
    SizeKey{"radius_mm", bits({sphere, capsule, cylinder, cone, helix, ramp}), 0},
    SizeKey{"length_mm", bits({capsule, cylinder, cone, ramp}), 0},
    SizeKey{"size_mm", bits({box, rounded_box}), 0},
    SizeKey{"edge_mm", bits({rounded_box}), bits({cylinder, cone})},
    SizeKey{"points_mm", bits({hull, mesh}), 0},
    SizeKey{"triangles", bits({mesh}), 0},
    SizeKey{"path_radius_mm", bits({helix}), 0},
    SizeKey{"drop_mm", bits({helix, ramp}), 0},
    SizeKey{"turns", bits({helix}), 0},
    SizeKey{"steps", 0, bits({helix, ramp})},
    SizeKey{"strips", 0, bits({helix, ramp})},
    SizeKey{"part", bits({compound}), 0},
    SizeKey{"friction_patch", 0, bits({plane})},
};

/// Reports sizes that a shape lacks, and keys that it doesn't use. Returns whether all is well.
bool check_sizes(Binder& table, ShapeKind kind) {
  const auto uses = [bit = bits({kind})](const SizeKey& size) {
    return ((size.needed | size.usable) & bit) != 0;
  };
  std::vector<std::string_view> used;
  for (const SizeKey& size : k_size_keys)
    if (uses(size)) used.push_back(size.key);
  bool all_well = true;
  for (const SizeKey& size : k_size_keys) {
    const bool given = table.given(size.key);
    const bool needed = (size.needed & bits({kind})) != 0;
    if (given && table.valid(size.key) && !uses(size))
      table.error(size.key, used.empty()
                                ? fmt::format("a {} has no sizes; remove the key", name_of(kind))
                                : fmt::format("a {} doesn't use this key; its keys are {}",
                                              name_of(kind), fmt::join(used, ", ")));
    if (!given && needed)
      table.error(size.key, fmt::format("missing; a {} needs it", name_of(kind)));
    if (given || needed) all_well = all_well && table.valid(size.key);
  }
  return all_well;
}

/// Reports sizes that are each in range but make no shape. Returns whether all is well.
bool check_proportions(Binder& table, const ShapeSizes& sizes) {
  const double radius_mm = k_mm_per_m * sizes.radius_m;
  const double length_mm = k_mm_per_m * sizes.length_m;
  const bool has_edges = (bits({sizes.kind}) & bits({cylinder, cone, rounded_box})) != 0;
  const double edge_mm_max = sizes.kind == rounded_box ? 0.5 * k_mm_per_m * sizes.size_m.minCoeff()
                                                       : std::min(radius_mm, 0.5 * length_mm);
  if (sizes.kind == helix && sizes.turns == 0) {
    table.error("turns", "must not be 0; a straight channel is a ramp");
  } else if (sizes.kind == helix && sizes.radius_m >= sizes.path_radius_m) {
    table.error("radius_mm", fmt::format("expected less than path_radius_mm, {} mm, found {}",
                                         k_mm_per_m * sizes.path_radius_m, radius_mm));
  } else if (sizes.kind == capsule && !(length_mm > 2 * radius_mm)) {
    table.error("length_mm", fmt::format("expected more than the diameter, {} mm, found {}",
                                         2 * radius_mm, length_mm));
  } else if (has_edges && k_mm_per_m * sizes.edge_m > edge_mm_max) {
    table.error("edge_mm",
                fmt::format("expected at most {}, {} mm, found {}",
                            sizes.kind == rounded_box ? "half of the least side"
                                                      : "the radius and half of the length",
                            edge_mm_max, k_mm_per_m * sizes.edge_m));
  } else {
    return true;
  }
  return false;
}

/// Reads an optional length. Leaves `value_m` unchanged if the file omits it.
void length_mm(Binder& table, std::string_view key, double& value_m, const NumberOptions& options) {
  if (table.optional_number(key, value_m, options)) value_m /= k_mm_per_m;
}

void place_mm(Binder& table, std::string_view key, Vec3& place_m, std::string_view help) {
  table.numbers(key, place_m, in_mm(help));
  place_m /= k_mm_per_m;
}

void bind_sizes(Binder& table, ShapeSizes& sizes,
                std::span<const request::Named<ShapeKind>> shapes) {
  table.choice<ShapeKind>("shape", sizes.kind, shapes, "kind of shape");
  length_mm(table, "radius_mm", sizes.radius_m,
            in_mm("radius; of a helix or ramp: radius of the half pipe", k_small_mm));
  length_mm(table, "length_mm", sizes.length_m,
            in_mm("length along the axis z, ends included; of a ramp: along x", k_small_mm));
  if (table.optional_numbers("size_mm", sizes.size_m, in_mm("sides of a box: x, y, z", k_small_mm)))
    sizes.size_m /= k_mm_per_m;
  length_mm(table, "edge_mm", sizes.edge_m,
            in_mm("radius of rounded edges; default for cylinders and cones: 2% of the "
                  "smaller of radius and length",
                  1e-4));
  if (sizes.edge_m == 0) sizes.edge_m = k_edge_share * std::min(sizes.radius_m, sizes.length_m);
  std::vector<std::array<double, 3>> points_mm;
  table.rows("points_mm", points_mm,
             {.count_min = 3, .count_max = request::k_array_numbers_max / 3},
             in_mm("points of a hull (4 to 1024) or mesh: [[x, y, z], ...]"));
  for (const auto& point_mm : points_mm)
    sizes.points_m.push_back(Vec3(point_mm.data()) / k_mm_per_m);
}

/// Binds the sizes of shapes that never move.
void bind_static_sizes(Binder& table, ShapeSizes& sizes) {
  table.rows("triangles", sizes.triangles,
             {.count_min = 1, .count_max = request::k_array_numbers_max / 3},
             {.minimum = 0,
              .maximum = request::k_array_numbers_max / 3,
              .help = "triangles of a mesh: points by number from 0, anticlockwise seen from "
                      "outside"});
  table.boolean("closed", sizes.closed, "whether a mesh must enclose a solid");
  length_mm(table, "path_radius_mm", sizes.path_radius_m,
            in_mm("of a helix: distance of the channel's middle from the axis", k_small_mm));
  length_mm(table, "drop_mm", sizes.drop_m,
            in_mm("of a helix or ramp: height of its start above its end", -k_far_mm));
  table.optional_number("turns", sizes.turns,
                        {.minimum = -1000,
                         .maximum = 1000,
                         .help = "of a helix: number of turns, anticlockwise if positive"});
  std::optional<std::uint32_t> steps;
  std::optional<std::uint32_t> strips;
  table.optional_integer(
      "steps", steps,
      {.minimum = 1,
       .maximum = 50'000,
       .help = "sections along a channel; default: 96 per turn, or 1 of a ramp"});
  table.optional_integer(
      "strips", strips,
      {.minimum = 2, .maximum = 64, .help = "strips across a channel; default: 8"});
  constexpr double k_steps_per_turn = 96;
  const double by_turns = std::ceil(k_steps_per_turn * std::fabs(sizes.turns));
  sizes.steps =
      steps.value_or(sizes.kind == ShapeKind::ramp
                         ? 1
                         : std::max<std::uint32_t>(1, static_cast<std::uint32_t>(by_turns)));
  sizes.strips = strips.value_or(8);
}

/// Reads a turn: Euler angles, or a quaternion.
void bind_turn(Binder& table, Quat& orientation) {
  Vec3 angles_deg = Vec3::Zero();
  const bool has_angles =
      table.optional_numbers("turn_deg", angles_deg,
                             {.minimum = -360,
                              .maximum = 360,
                              .unit = "degrees",
                              .help = "rotation: about x, then y, then z, each axis fixed"});
  std::array<double, 4> q{};
  const bool has_quaternion = table.optional_numbers(
      "quaternion", q,
      {.minimum = -1, .maximum = 1, .help = "rotation as w, x, y, z, instead of turn_deg"});
  if (has_angles && has_quaternion) {
    table.error("quaternion", "set either turn_deg or quaternion, not both");
  } else if (has_angles) {
    for (int axis = 0; axis < 3; ++axis)
      orientation =
          math::composed(math::quaternion_of_rotation_vector(
                             request::radians_of_degrees(angles_deg[axis]) * Vec3::Unit(axis)),
                         orientation);
  } else if (has_quaternion) {
    if (!(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3] > 0.01))
      return table.error("quaternion", "the numbers are too small to be a rotation");
    orientation = math::normalized(Quat(q[0], q[1], q[2], q[3]));
  }
}

void bind_part(Binder& table, PartDescription& part) {
  bind_sizes(table, part.sizes, std::span(k_shape_names).first(k_part_shapes));
  place_mm(table, "at_mm", part.pose.position_m, "place in the compound's frame");
  bind_turn(table, part.pose.orientation);
  table.optional_number("density_kgpm3", part.density_kgpm3,
                        {.minimum = 0.001,
                         .maximum = 1e6,
                         .unit = "kg/m3",
                         .help = "density; default: that of the body's material"});
  if (table.line() == 0 || !table.valid("shape") || !check_sizes(table, part.sizes.kind) ||
      !check_proportions(table, part.sizes))
    return;
  const auto form = body_form(part.sizes, {}, 1);
  if (!form) table.error(form.error().key, form.error().message);
}

// ---- copies -------------------------------------------------------------------------------------

void bind_row(Binder& table, Copies& copies) {
  table.integer("count", copies.count[0],
                {.minimum = 1, .maximum = k_objects_max, .help = "number of copies"});
  place_mm(table, "step_mm", copies.step_m, "from one copy to the next");
}

void bind_grid(Binder& table, Copies& copies) {
  std::array<double, 3> count{1, 1, 1};
  table.numbers("count", count,
                {.minimum = 1, .maximum = k_objects_max, .help = "copies along x, y, z"});
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (count[axis] != std::floor(count[axis]) && table.valid("count"))
      table.error("count", "the numbers of copies must be whole numbers");
    copies.count[axis] = static_cast<std::uint32_t>(count[axis]);
  }
  place_mm(table, "step_mm", copies.step_m, "distances of the copies along x, y, z");
}

void bind_ring(Binder& table, Copies& copies) {
  table.integer("count", copies.count[0],
                {.minimum = 1, .maximum = k_objects_max, .help = "number of copies"});
  double radius_mm = 0;
  table.number("radius_mm", radius_mm, in_mm("distance of the copies from at_mm", 0));
  copies.radius_m = radius_mm / k_mm_per_m;
  table.angle_deg("from_deg", copies.from_rad,
                  {.minimum = -360, .maximum = 360, .help = "angle of the first copy, from x"});
  double to_deg = 360;
  copies.full_circle = !table.optional_number(
      "to_deg", to_deg,
      {.minimum = -3600,
       .maximum = 3600,
       .unit = "degrees",
       .help = "angle of the last copy; default: the copies fill the circle"});
  copies.to_rad = (copies.full_circle ? copies.from_rad : 0) + request::radians_of_degrees(to_deg);
}

void bind_copies(Binder& body, Copies& copies) {
  const auto is_given = [&](const char* key, CopyKind kind, std::string_view help,
                            void (*bind)(Binder&, Copies&)) {
    Copies read;
    if (!body.table<Copies>(key, read, help, bind)) return;
    if (copies.kind != CopyKind::none) body.error(key, "set only one of row, grid and ring");
    read.kind = kind;
    copies = read;
  };
  is_given("row", CopyKind::row, "copies in a row, named NAME 1, NAME 2, ...", &bind_row);
  is_given("grid", CopyKind::grid, "copies in a grid, counted along x, then y, then z", &bind_grid);
  is_given("ring", CopyKind::ring,
           "copies in a ring about z, around at_mm; each is turned about z by its angle",
           &bind_ring);
}

void bind_friction_patch(Binder& table, FrictionPatch& patch) {
  const auto range = [&](std::string_view key, std::array<double, 2>& range_m) {
    table.numbers(key, range_m, in_mm("from and to, in the plane's frame"));
    range_m = {range_m[0] / k_mm_per_m, range_m[1] / k_mm_per_m};
    if (table.line() > 0 && table.valid(key) && !(range_m[0] < range_m[1]))
      table.error(key, "the first number must be less than the second");
  };
  range("x_mm", patch.x_m);
  range("y_mm", patch.y_m);
  table.number("friction", patch.friction,
               {.minimum = 0, .maximum = k_friction_max, .help = "coefficient of friction"});
}

// ---- bodies -------------------------------------------------------------------------------------

/// Checks what a body's keys mean together, and makes its shape once.
void check_body(Binder& table, BodyDescription& body, const SceneDescription& scene, Names& names) {
  const ShapeKind kind = body.sizes.kind;
  if (!table.valid("shape") || !check_sizes(table, kind) || !check_proportions(table, body.sizes))
    return;
  if ((bits({kind}) & bits({plane, mesh, helix, ramp})) != 0) {
    if (table.given("static") && !body.is_static)
      table.error("static", fmt::format("a {} can't move; remove the key", name_of(kind)));
    body.is_static = true;
    table.settle("static", "true");
  }
  if (body.is_static) {
    // Compare values, because a normalised request has every key.
    const std::array<std::pair<const char*, bool>, 5> moves{
        {{"velocity_mps", !physics::is_zero(body.velocity_mps)},
         {"spin_radps", !physics::is_zero(body.spin_radps)},
         {"start_s", body.start_s > 0},
         {"rests", body.rests},
         {"mass_kg", body.mass_kg.has_value()}}};
    for (const auto& [key, is_set] : moves) {
      if (is_set) table.error(key, "a static body has no such key; remove it");
    }
  }
  if (body.rests && body.start_s > 0)
    table.error("rests", "a body at rest is there from the start; remove start_s");
  constexpr std::array<const char*, 4> k_copy_keys{"name", "row", "grid", "ring"};
  const char* const copied = k_copy_keys[static_cast<std::size_t>(body.copies.kind)];
  const std::size_t count = count_of(body.copies);
  if (count + names.objects.all().size() > k_objects_max) {
    table.error(copied,
                fmt::format("the scene has more than {} bodies and static things", k_objects_max));
    return;
  }
  const bool is_channel = (bits({kind}) & bits({helix, ramp})) != 0;
  names.triangles += count * (is_channel ? 2 * std::size_t{body.sizes.steps} * body.sizes.strips
                                         : body.sizes.triangles.size());
  if (names.triangles > k_mesh_triangles_max) {
    table.error(is_channel ? "steps" : copied,
                fmt::format("with this body, the scene has {} triangles; the limit is {}",
                            names.triangles, k_mesh_triangles_max));
    return;
  }
  for (const Copy& copy : copies_of(body))
    names.objects.add(table, "name", copy.name);
  if (kind == mesh) {
    const auto made = mesh_form(body.sizes, {});
    if (!made) table.error(made.error().key, made.error().message);
  } else if ((bits({kind}) & bits({plane, helix, ramp})) == 0) {
    const auto form =
        body_form(body.sizes, body.parts, scene.materials[body.material].density_kgpm3);
    if (!form) table.error(form.error().key, form.error().message);
  }
}

void bind_body(Binder& table, BodyDescription& body, const SceneDescription& scene, Names& names) {
  body.line = table.line();
  table.required_text("name", body.name, a_name("name"));
  bind_sizes(table, body.sizes, k_shape_names);
  bind_static_sizes(table, body.sizes);
  table.tables<PartDescription>(
      "part", body.parts, {.count_max = k_parts_max, .help = "parts of a compound"}, &bind_part);
  table.boolean("static", body.is_static, "whether the body never moves");
  std::string material;
  if (table.optional_text("material", material,
                          a_name("name of a [[world.material]]; default: the first")))
    body.material = names.materials.find(table, "material", material);
  std::string group = "default";
  table.optional_text("group", group,
                      a_name("group for [[world.no_contact]]; default: \"default\""));
  body.group = names.groups.number(group);
  if (names.groups.all().size() > k_groups_max) {
    table.error("group", fmt::format("the scene has more than {} groups", k_groups_max));
    body.group = 0;
  }
  table.optional_number("mass_kg", body.mass_kg,
                        {.minimum = 1e-9,
                         .maximum = 1e9,
                         .unit = "kg",
                         .help = "mass; default: the material's density times the volume"});
  place_mm(table, "at_mm", body.place.position_m, "place of the shape's origin");
  bind_turn(table, body.place.orientation);
  table.numbers("velocity_mps", body.velocity_mps,
                {.minimum = -1000,
                 .maximum = 1000,
                 .unit = "m/s",
                 .help = "velocity of the shape's origin at the start"});
  table.numbers("spin_radps", body.spin_radps,
                {.minimum = -1000,
                 .maximum = 1000,
                 .unit = "rad/s",
                 .help = "angular velocity at the start"});
  table.number("start_s", body.start_s, in_s("time at which the body appears and starts"));
  table.boolean("rests", body.rests,
                "whether the body starts at rest on what it touches, like a bowling pin");
  bind_copies(table, body.copies);
  table.tables<FrictionPatch>("friction_patch", body.friction,
                              {.count_max = physics::FrictionMap::k_rectangles_max,
                               .help = "rectangles of a plane with friction of their own"},
                              &bind_friction_patch);
  if (table.line() > 0 && table.valid("part")) check_body(table, body, scene, names);
}

}  // namespace

std::string_view name_of(ShapeKind kind) {
  return k_shape_names[static_cast<std::size_t>(kind)].name;
}

std::string unknown(std::string_view what, const std::string& name,
                    const std::vector<std::string>& names) {
  constexpr std::size_t k_listed_max = 10;
  std::string text = fmt::format("no {} is named {}", what, request::toml_string(name));
  if (const auto near = request::nearest(name, names))
    return text + fmt::format("; did you mean {}?", request::toml_string(*near));
  if (!names.empty() && names.size() <= k_listed_max)
    text += fmt::format("; the names are \"{}\"", fmt::join(names, "\", \""));
  return text;
}

void NameList::add(Binder& table, std::string_view key, const std::string& name) {
  if (table.line() == 0 || !table.valid(key)) return;
  if (name.empty()) {
    table.error(key, fmt::format("expected the {}'s name, found an empty string", what_));
  } else if (request::printable(name, 4 * k_name_characters_max) != name) {
    table.error(key, "expected a name without control characters");
  } else if (std::ranges::find(names_, name) != names_.end()) {
    table.error(key,
                fmt::format("another {} is already named {}", what_, request::toml_string(name)));
  } else {
    names_.push_back(name);
  }
}

std::uint32_t NameList::find(Binder& table, std::string_view key, const std::string& name) const {
  const auto at = std::ranges::find(names_, name);
  if (at != names_.end()) return static_cast<std::uint32_t>(at - names_.begin());
  table.error(key, unknown(what_, name, names_));
  return 0;
}

std::uint32_t NameList::number(const std::string& name) {
  const auto at = std::ranges::find(names_, name);
  if (at == names_.end()) names_.push_back(name);
  return static_cast<std::uint32_t>(std::ranges::find(names_, name) - names_.begin());
}

void bind_bodies(Binder& world, SceneDescription& scene, Names& names) {
  names.groups.number("default");
  world.tables<BodyDescription>(
      "body", scene.bodies,
      {.count_max = k_objects_max, .help = "bodies, and static things that they meet"},
      [&](Binder& table, BodyDescription& body) { bind_body(table, body, scene, names); });
  if (scene.bodies.empty() && world.line() > 0 && world.valid("body"))
    world.error("body", "missing; a scene needs at least one [[world.body]]");
}

}  // namespace sleight::worlds::user_scene
