#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <functional>
#include <numbers>
#include <optional>
#include <utility>

#include "common/request/text.h"
#include "worker/worlds/user_scene/request.h"
#include "worker/worlds/user_scene/request_parts.h"

namespace sleight::worlds::user_scene {
namespace {

using request::Binder;
using request::NumberOptions;

constexpr std::size_t k_constraints_max = 1000;  ///< of one kind

/// Directions of the faces 1 to 6 of a box, as pips are drawn on dice.
const std::array<Vec3, 6> k_faces{Vec3::UnitX(),  Vec3::UnitY(),  Vec3::UnitZ(),
                                  -Vec3::UnitZ(), -Vec3::UnitY(), -Vec3::UnitX()};

constexpr const char* k_sigma_help =
    "scale of the distance: a miss by this much divides p_c by 1.65";
constexpr const char* k_tolerance_help = "greatest distance at which the constraint is met";
constexpr const char* k_at_help = "time at which it must hold; default: at the end, at rest";

/// A named box.
struct NamedRegion {
  std::string name;
  Region region;
};

std::vector<NamedRegion> bind_regions(Binder& world) {
  std::vector<NamedRegion> regions;
  NameList names("region");
  world.tables<NamedRegion>(
      "region", regions, {.count_max = k_constraints_max, .help = "boxes that constraints name"},
      [&](Binder& table, NamedRegion& named) {
        table.required_text("name", named.name, a_name("region's name"));
        names.add(table, "name", named.name);
        const auto corner = [&](const char* key, Vec3& corner_m, const char* help) {
          if (table.optional_numbers(key, corner_m, in_mm(help))) {
            corner_m *= k_m_per_mm;
          } else if (table.line() > 0 && table.valid(key)) {
            table.error(key, "missing; a region needs it");
          }
        };
        corner("low_mm", named.region.low_m, "least x, y, z");
        corner("high_mm", named.region.high_m, "greatest x, y, z");
        if (table.line() > 0 && table.is_sound() &&
            (named.region.high_m - named.region.low_m).minCoeff() < 0)
          table.error("high_mm", "must be at least low_mm along each axis");
      });
  return regions;
}

/// A constraint's keys, besides those that its kind reads itself.
struct ConstraintKeys {
  Constraint made;
  std::vector<std::string> bodies{};
  bool any = false;
};

class ConstraintBinder {
 public:
  ConstraintBinder(Binder& section, Parameters& parameters, const std::vector<NamedRegion>& regions)
      : section_(section), parameters_(parameters), regions_(regions) {}

  void bind_all() {
    tables("region", Asks::region, "a body must be in a region", &ConstraintBinder::bind_region);
    tables("place", Asks::place, "a body must be at a point", &ConstraintBinder::bind_place);
    tables("face", Asks::face, "a face of a body must be on top", &ConstraintBinder::bind_face);
    tables("topples", Asks::topples, "a body's upward axis must end more than 45 degrees off",
           &ConstraintBinder::bind_tilt);
    tables("stands", Asks::stands, "a body's upward axis must end within 5 degrees of upward",
           &ConstraintBinder::bind_tilt);
    tables("count", Asks::count, "bodies of a group must be in a region",
           &ConstraintBinder::bind_count);
    tables("event", Asks::event, "a body must hit another", &ConstraintBinder::bind_event);
    tables("order", Asks::order, "events must come in this order", &ConstraintBinder::bind_order);
    tables("never", Asks::never, "a body must not hit another", &ConstraintBinder::bind_never);
  }

 private:
  using Bind = void (ConstraintBinder::*)(Binder&, ConstraintKeys&);
  bool is_used(const Binder& table) const {
    return table.line() > 0 && table.is_sound() && parameters_.built != nullptr;
  }

  void tables(const char* key, Asks asks, const char* help, Bind bind) {
    std::vector<ConstraintKeys> all;
    section_.tables<ConstraintKeys>(
        key, all, {.count_max = k_constraints_max, .help = help},
        [&](Binder& table, ConstraintKeys& keys) {
          const bool names_bodies = asks != Asks::count && asks != Asks::order;
          keys.made.asks = asks;
          keys.made.line = table.line();
          table.optional_text("name", keys.made.name,
                              a_name("name in archives; default: bodies and kind"));
          if (names_bodies) {
            keys.bodies = bind_body_names(table);
            table.boolean("any", keys.any, "whether it suffices that one of the bodies meets it");
          }
          (this->*bind)(table, keys);
          if (!is_used(table)) return;
          if (names_bodies && keys.bodies.empty())
            return table.error("body", "missing; set body or bodies");
          if (names_bodies) keys.made.bodies = find_moving(table, keys.bodies, parameters_);
          if (asks == Asks::face && table.given("up")) check_boxes(table, keys.made);
          if (table.is_sound()) add(table, keys, key);
        });
  }

  void check_boxes(Binder& table, const Constraint& made) const {
    for (const std::uint32_t body : made.bodies) {
      const ShapeKind kind = parameters_.described(body).sizes.kind;
      if (kind != ShapeKind::box)
        return table.error("up",
                           fmt::format("is for boxes, but {} is a {}; set axis",
                                       request::toml_string(object(body).name), name_of(kind)));
    }
  }

  /// Adds a constraint for each body, or one for all.
  void add(Binder& table, const ConstraintKeys& keys, const char* kind) {
    const std::vector<std::uint32_t>& bodies = keys.made.bodies;
    if (table.given("name")) names_.add(table, "name", keys.made.name);
    if (std::ranges::find_first_of(bodies, keys.made.hits) != bodies.end())
      table.error("hits", "a body can't hit itself; name another body");
    if (!table.is_sound()) return;
    const bool each = !keys.any && bodies.size() > 1 && keys.made.asks != Asks::count;
    std::string name = keys.made.name;
    if (!table.given("name"))
      name =
          fmt::format("{}{}{}", fmt::join(keys.bodies, ", "), keys.bodies.empty() ? "" : " ", kind);
    for (std::size_t i = 0; i < (each ? bodies.size() : 1); ++i) {
      Constraint made = keys.made;
      if (each) made.bodies = {bodies[i]};
      made.name = each ? fmt::format("{}: {}", name, object(bodies[i]).name) : name;
      for (const Constraint& other : parameters_.constraints) {
        const std::string why = contradiction_of(other, made);
        if (!why.empty())
          return table.error(
              table.given("body") ? "body" : "bodies",
              fmt::format("contradicts the constraint in line {}: {}", other.line, why));
      }
      parameters_.constraints.push_back(std::move(made));
    }
  }

  void bind_time(Binder& table, Constraint& made) {
    table.optional_number("at_s", made.at_s, in_s(k_at_help));
    if (made.at_s && *made.at_s > parameters_.scene.end_s)
      table.error("at_s", fmt::format("is after end_s of [world], {} s", parameters_.scene.end_s));
  }

  /// `scale`: the unit in SI units.
  static void bind_scale(Binder& table, Constraint& made, std::string_view unit, double scale) {
    NumberOptions options{.minimum = 1e-6, .maximum = k_far_mm, .unit = unit, .help = k_sigma_help};
    table.required_number(fmt::format("sigma_{}", unit), made.sigma, options);
    made.sigma *= scale;
    options.minimum = 0;
    options.help = k_tolerance_help;
    table.number(fmt::format("tolerance_{}", unit), made.tolerance, options);
    made.tolerance *= scale;
  }

  static void bind_angles(Binder& table, Constraint& made, double tolerance_rad) {
    made.sigma = 10 * k_rad_per_deg;
    table.angle_deg("sigma_deg", made.sigma,
                    {.minimum = 0.001, .maximum = 360, .help = k_sigma_help});
    made.tolerance = tolerance_rad;
    table.angle_deg("tolerance_deg", made.tolerance,
                    {.minimum = 0, .maximum = 180, .help = k_tolerance_help});
  }

  void bind_named_region(Binder& table, Constraint& made) {
    std::string name;
    table.required_text("region", name,
                        a_name("name of a [[world.region]], or of a static body: the box around "
                               "it"));
    if (!is_used(table)) return;
    std::vector<std::string> names;
    for (const NamedRegion& region : regions_) {
      names.push_back(region.name);
      if (region.name != name) continue;
      made.region = region.region;
      return;
    }
    const BuiltScene& built = *parameters_.built;
    for (std::uint32_t i = built.moving; i < built.objects.size(); ++i) {
      names.push_back(built.objects[i].name);
      if (names.back() != name) continue;
      if (built.objects[i].kind == ObjectKind::plane)
        return table.error("region", fmt::format("{} is a plane, which has no box around it; name "
                                                 "a [[world.region]]",
                                                 request::toml_string(name)));
      made.region = box_of(built, i);
      return;
    }
    table.error("region", unknown("region or static body", name, names));
  }

  void bind_region(Binder& table, ConstraintKeys& keys) {
    bind_named_region(table, keys.made);
    table.boolean("whole", keys.made.whole,
                  "whether all of the body must be inside, not only its origin");
    bind_scale(table, keys.made, "mm", k_m_per_mm);
    bind_time(table, keys.made);
  }

  void bind_place(Binder& table, ConstraintKeys& keys) {
    std::vector<double> place_mm;
    table.numbers("at_mm", place_mm, {.count_min = 2, .count_max = 3, .required = true},
                  in_mm("place of the origin: x, y and perhaps z"));
    for (std::size_t axis = 0; axis < place_mm.size(); ++axis) {
      const auto i = static_cast<Eigen::Index>(axis);
      keys.made.region.low_m[i] = keys.made.region.high_m[i] = k_m_per_mm * place_mm[axis];
    }
    bind_scale(table, keys.made, "mm", k_m_per_mm);
    bind_time(table, keys.made);
  }

  void bind_face(Binder& table, ConstraintKeys& keys) {
    std::optional<std::uint32_t> up;
    table.optional_integer("up", up,
                           {.minimum = 1,
                            .maximum = 6,
                            .help = "face of a box, numbered as a die: 1 is x, 2 is y, 3 is z; "
                                    "opposite faces add up to 7"});
    Vec3& axis = keys.made.axis;
    const bool has_axis = table.optional_numbers(
        "axis", axis,
        {.minimum = -1,
         .maximum = 1,
         .help = "direction in the body that must point upward, instead of up"});
    bind_angles(table, keys.made, 20 * k_rad_per_deg);
    bind_time(table, keys.made);
    if (!is_used(table)) return;
    if (up.has_value() == has_axis) return table.error("up", "set either up or axis");
    if (up) axis = k_faces[*up - 1];
    if (math::norm(axis) < 0.1)
      return table.error("axis", "the numbers are too small to be a direction");
    axis = math::normalized(axis);
  }

  void bind_tilt(Binder& table, ConstraintKeys& keys) {
    bind_angles(table, keys.made, 0);
    bind_time(table, keys.made);
  }

  void bind_count(Binder& table, ConstraintKeys& keys) {
    std::string group;
    table.required_text("group", group, a_name("the bodies' group"));
    bind_named_region(table, keys.made);
    table.integer(
        "at_least", keys.made.at_least,
        {.minimum = 0,
         .maximum = k_objects_max,
         .help = "number of bodies with their origin in the region; 0: all of the group"});
    keys.made.log_lambda = 2.5;
    table.number(
        "log_lambda", keys.made.log_lambda,
        {.minimum = 0, .maximum = 100, .help = "each missing body divides p_c by e to this power"});
    bind_time(table, keys.made);
    if (!is_used(table)) return;
    for (std::uint32_t i = 0; i < parameters_.built->moving; ++i) {
      if (parameters_.scene.groups[parameters_.described(i).group] == group)
        keys.made.bodies.push_back(i);
    }
    const auto there = static_cast<std::uint32_t>(keys.made.bodies.size());
    if (there == 0) {
      table.error("group",
                  fmt::format("no moving body has the group {}", request::toml_string(group)));
    } else if (keys.made.at_least > there) {
      table.error("at_least", fmt::format("the group has only {} moving bodies", there));
    } else if (keys.made.at_least == 0) {
      keys.made.at_least = there;
    }
  }

  void bind_hits(Binder& table, Constraint& made) {
    std::string hits;
    table.required_text("hits", hits,
                        a_name("name of what the body hits; a body with copies: any of them"));
    table.number("at_least_mps", made.at_least_mps,
                 {.minimum = 0,
                  .maximum = 1000,
                  .unit = "m/s",
                  .help = "minimum speed of approach; slower hits don't count"});
    if (is_used(table)) made.hits = find_objects(table, "hits", hits, parameters_);
  }

  void bind_event(Binder& table, ConstraintKeys& keys) {
    Constraint& made = keys.made;
    bind_hits(table, made);
    table.integer("nth", made.nth,
                  {.minimum = 1, .maximum = 10'000, .help = "which of the pair's hits"});
    bind_event_time(table, made);
    table.number("window_s", made.window_s,
                 in_s("greatest difference in time that is told by the hit itself", 0.001));
    double near_mm = 10;
    table.number("near_mm", near_mm,
                 in_mm("scale of the gap by which a hit is missed in its window", 0.001));
    made.near_m = k_m_per_mm * near_mm;
  }

  void bind_event_time(Binder& table, Constraint& made) const {
    const auto time = [&](const char* key, double& value, const char* help) {
      return table.optional_number(key, value, in_s(help));
    };
    double at_s = 0;
    double frame = 0;
    double frames_per_s = 24;
    const bool has_at = time("at_s", at_s, "time of the hit");
    const bool has_before = time("before_s", made.to_s, "latest time of the hit");
    const bool has_after = time("after_s", made.from_s, "earliest time of the hit");
    const bool has_frame = table.optional_number(
        "frame", frame, {.minimum = 0, .maximum = 1e6, .help = "frame of the hit, from 0"});
    table.number("frames_per_s", frames_per_s,
                 {.minimum = 1, .maximum = 10'000, .unit = "1/s", .help = "rate of frames"});
    table.numbers("beats_s", made.times_s, {.count_min = 1, .count_max = 1000},
                  in_s("the hit must be on one of these times"));
    made.sigma = made.window_s;
    const bool has_sigma = time("sigma_s", made.sigma, k_sigma_help);
    const bool has_tolerance = time("tolerance_s", made.tolerance, k_tolerance_help);
    if (!is_used(table)) return;
    const bool has_beats = !made.times_s.empty();
    if (has_at) made.times_s.push_back(at_s);
    if (has_frame) made.times_s.push_back(frame / frames_per_s);
    std::ranges::sort(made.times_s);
    const auto given =
        std::ranges::count(std::array{has_at, has_frame, has_beats, has_before || has_after}, true);
    const char* const key = has_at       ? "at_s"
                            : has_frame  ? "frame"
                            : has_before ? "before_s"
                                         : "after_s";
    if (given > 1)
      return table.error(key,
                         "set only one of at_s, frame, beats_s, and the range before_s, after_s");
    if (made.from_s > made.to_s) return table.error("before_s", "must be at least after_s");
    const double latest_s = made.times_s.empty() ? made.from_s : made.times_s.back();
    if (latest_s > parameters_.scene.end_s)
      return table.error(has_beats ? "beats_s" : key,
                         fmt::format("is after end_s of [world], {} s", parameters_.scene.end_s));
    if (given > 0 && !has_sigma)
      return table.error("sigma_s", "missing; an event with a time needs it");
    if (!made.times_s.empty() && !has_tolerance)
      return table.error("tolerance_s", "missing; an event at a time needs it");
    if (made.sigma <= 0) table.error("sigma_s", "must be above 0");
  }

  void bind_order(Binder& table, ConstraintKeys& keys) {
    std::vector<std::string> events;
    table.texts("events", events, {.count_min = 2, .count_max = 1000, .required = true},
                {.characters_max = 2 * k_name_characters_max,
                 .help = "names of [[constraint.event]], the first first"});
    bind_scale(table, keys.made, "s", 1);
    if (!is_used(table)) return;
    std::vector<std::string> names;
    std::vector<std::uint32_t> numbers;
    for (std::uint32_t i = 0; i < parameters_.constraints.size(); ++i) {
      if (parameters_.constraints[i].asks != Asks::event) continue;
      names.push_back(parameters_.constraints[i].name);
      numbers.push_back(i);
    }
    for (const std::string& event : events) {
      const auto at = std::ranges::find(names, event);
      if (at == names.end()) return table.error("events", unknown("event", event, names));
      const std::uint32_t number = numbers[static_cast<std::size_t>(at - names.begin())];
      if (std::ranges::count(keys.made.events, number) > 0)
        return table.error("events", fmt::format("{} is named twice", request::toml_string(event)));
      keys.made.events.push_back(number);
    }
  }

  void bind_never(Binder& table, ConstraintKeys& keys) {
    bind_hits(table, keys.made);
    table.number("sigma_s", keys.made.sigma,
                 in_s("scale of the time between the hit and the scene's end", 0.001));
  }

  const Object& object(std::uint32_t number) const { return parameters_.built->objects[number]; }

  Binder& section_;
  Parameters& parameters_;
  const std::vector<NamedRegion>& regions_;
  NameList names_{"constraint"};
};

}  // namespace

void bind_constraints(request::WorldSections& sections, Parameters& parameters) {
  const std::vector<NamedRegion> regions = bind_regions(sections.world);
  ConstraintBinder(sections.constraint, parameters, regions).bind_all();
}

}  // namespace sleight::worlds::user_scene
