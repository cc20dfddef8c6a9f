#include "worker/worlds/dice/request.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <fmt/format.h>

#include "common/math/elementary.h"
#include "common/request/settled.h"

namespace sleight::worlds::dice {
namespace {

using request::Binder;
using request::NumberOptions;

constexpr std::array<request::Named<Numbering>, 2> k_numbering_names{
    {{"free", Numbering::free}, {"fixed", Numbering::fixed}}};
constexpr std::array<request::Named<StartOrientation>, 2> k_orientation_names{
    {{"uniform", StartOrientation::uniform}, {"fixed", StartOrientation::fixed}}};
constexpr std::uint32_t k_goals_max = 100;  ///< of one sort
constexpr double k_far_mm = 100'000;

// Help of several keys.
constexpr std::string_view k_sd_help = "standard deviation; 0: fixed";
constexpr std::string_view k_sigma_help =
    "standard deviation of this goal's factor in the constraint p_c";
constexpr std::string_view k_tolerance_help = "maximum distance at which the goal is satisfied";
constexpr std::string_view k_step_help = "standard deviation of proposed steps, before halvings";

/// Binds w, x, y and z.
void bind_quaternion(Binder& table, std::string_view help, std::array<double, 4>& q) {
  constexpr std::array<const char*, 4> k_parts{"qw", "qx", "qy", "qz"};
  for (std::size_t i = 0; i < 4; ++i)
    table.number(k_parts[i], q[i], {.minimum = -1, .maximum = 1, .help = help});
}

bool is_rotation(const std::array<double, 4>& q) {
  return q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3] > 0.01;
}

// Starts.

/// One [[world.die]].
struct DieKeys {
  DieStart start;
  std::optional<double> y_mm;
  std::optional<std::uint32_t> up;
  double yaw_rad = 0;
  std::array<double, 4> quaternion{1, 0, 0, 0};
};

void bind_velocities(Binder& die, DieStart& start) {
  for (int k = 0; k < 3; ++k) {
    const char axis = "xyz"[k];
    die.number(fmt::format("velocity_{}_mps", axis), start.velocity_mps[k],
               {.minimum = -100, .maximum = 100, .unit = "m/s", .help = "mean velocity"});
    die.number(fmt::format("velocity_{}_sd_mps", axis), start.velocity_sd_mps[k],
               {.minimum = 0, .maximum = 100, .unit = "m/s", .help = k_sd_help});
  }
  for (int k = 0; k < 3; ++k) {
    const char axis = "xyz"[k];
    die.number(
        fmt::format("spin_{}_radps", axis), start.spin_radps[k],
        {.minimum = -1000, .maximum = 1000, .unit = "rad/s", .help = "mean angular velocity"});
    die.number(fmt::format("spin_{}_sd_radps", axis), start.spin_sd_radps[k],
               {.minimum = 0, .maximum = 1000, .unit = "rad/s", .help = k_sd_help});
  }
}

void bind_orientation(Binder& die, DieKeys& keys) {
  die.choice<StartOrientation>("orientation", keys.start.orientation, k_orientation_names,
                               "initial orientation: uniformly random, or fixed by `up` and "
                               "yaw_deg, or by the quaternion qw to qz");
  die.optional_integer(
      "up", keys.up,
      {.minimum = 1, .maximum = k_faces, .help = "top face of a fixed orientation; default: 3"});
  die.angle_deg(
      "yaw_deg", keys.yaw_rad,
      {.minimum = -360,
       .maximum = 360,
       .help = "for a fixed orientation: rotation about the vertical; face `up` stays on top"});
  bind_quaternion(die, "quaternion of a fixed orientation, instead of `up` and yaw_deg",
                  keys.quaternion);
  // Compare values, because a normalised request has every key.
  const bool gives_quaternion = keys.quaternion != DieKeys{}.quaternion;
  if (!die.valid("orientation")) return;
  const bool is_fixed = keys.start.orientation == StartOrientation::fixed;
  if (!is_fixed && (keys.up || gives_quaternion)) {
    die.error("orientation", "must be \"fixed\" if `up` or a quaternion is given");
  } else if (keys.up && gives_quaternion) {
    die.error("up", "set either `up` or a quaternion, not both");
  } else if (!is_rotation(keys.quaternion)) {
    die.error("qw", "the quaternion is too small to be a rotation");
  } else if (is_fixed) {
    const auto& q = keys.quaternion;
    keys.start.fixed_orientation =
        gives_quaternion ? math::normalized(Quat(q[0], q[1], q[2], q[3]))
                         : orientation_with_face_up(keys.up.value_or(3), keys.yaw_rad);
  }
}

void bind_die(Binder& die, DieKeys& keys) {
  DieStart& start = keys.start;
  const auto place = [&](std::string_view key, double& value_m, std::string_view help) {
    die.length_mm(key, value_m, {.minimum = -k_far_mm, .maximum = k_far_mm, .help = help});
  };
  const auto sd = [&](std::string_view key, double& value_m) {
    die.length_mm(key, value_m, {.minimum = 0, .maximum = 1000, .help = k_sd_help});
  };
  place("x_mm", start.position_m.x(), "mean initial position of the centre");
  die.optional_number("y_mm", keys.y_mm,
                      {.minimum = -k_far_mm,
                       .maximum = k_far_mm,
                       .unit = "mm",
                       .help = "mean initial position of the centre; default: dice 45 mm apart"});
  die.length_mm("height_mm", start.position_m.z(),
                {.minimum = 0, .maximum = k_far_mm, .help = "mean initial height of the centre"});
  sd("x_sd_mm", start.position_sd_m.x());
  sd("y_sd_mm", start.position_sd_m.y());
  sd("height_sd_mm", start.position_sd_m.z());
  bind_velocities(die, start);
  bind_orientation(die, keys);
  die.number("start_s", start.start_s,
             {.minimum = 0, .maximum = 100, .unit = "s", .help = "release time"});
}

void bind_dice(Binder& world, WorldParameters& p) {
  std::optional<std::uint32_t> count;
  std::vector<DieKeys> given;
  world.optional_integer("dice", count,
                         {.minimum = 1,
                          .maximum = k_dice_max,
                          .help = "number of dice; default: number of tables [[world.die]], or 1"});
  world.tables<DieKeys>("die", given,
                        {.count_max = k_dice_max, .help = "initial state of each die"}, bind_die);
  if (count && !given.empty() && *count != given.size() && world.valid("dice")) {
    world.error("dice",
                fmt::format("must equal {}, the number of [[world.die]] tables, or be absent",
                            given.size()));
  }
  if (given.empty()) given.resize(count.value_or(1));
  p.dice.clear();
  for (std::size_t i = 0; i < given.size(); ++i) {
    const double place = static_cast<double>(i) - 0.5 * static_cast<double>(given.size() - 1);
    DieStart& start = given[i].start;
    start.position_m.y() = given[i].y_mm ? *given[i].y_mm / 1e3 : k_dice_apart_m * place;
    p.dice.push_back(start);
  }
}

// Keys of the table and of the rest of the world.

void bind_range(Binder& world, const std::string& name, Range& range, double maximum) {
  const std::string low = name + "_low";
  const std::string high = name + "_high";
  world.number(low, range.low,
               {.minimum = 0,
                .maximum = maximum,
                .help = "minimum of the coefficient at the table's control points"});
  world.number(high, range.high,
               {.minimum = 0,
                .maximum = maximum,
                .help = "maximum of the coefficient at the table's control points; if it equals "
                        "the minimum, the coefficient is constant"});
  if (world.all_valid({low, high}) && range.low > range.high) {
    world.error(high, fmt::format("must be at least {}", low));
    range = {range.high, range.high};
  }
}

void bind_world(Binder& world, WorldParameters& p) {
  bind_dice(world, p);
  world.length_mm("side_mm", p.side_m,
                  {.minimum = 1, .maximum = 1000, .help = "edge length of a die"});
  world.number("density_kgpm3", p.density_kgpm3,
               {.minimum = 1, .maximum = 30000, .unit = "kg/m3", .help = "density of the dice"});
  world.number("dice_restitution", p.dice_restitution,
               {.minimum = 0, .maximum = 1, .help = "coefficient of restitution between dice"});
  world.number("dice_friction", p.dice_friction,
               {.minimum = 0, .maximum = 10, .help = "friction coefficient between dice"});
  world.number(
      "gravity_mps2", p.gravity_mps2,
      {.minimum = 0.01, .maximum = 1000, .unit = "m/s2", .help = "gravitational acceleration"});
  world.number("time_max_s", p.time_max_s,
               {.minimum = 0.01,
                .maximum = 100,
                .unit = "s",
                .help = "time limit for dice that do not come to rest"});
  TableParameters& table = p.table;
  world.length_mm(
      "spacing_mm", table.spacing_m,
      {.minimum = 1, .maximum = 10000, .help = "distance between the table's control points"});
  world.integer("columns", table.columns,
                {.minimum = 1, .maximum = k_grid_max, .help = "number of control points along x"});
  world.integer("rows", table.rows,
                {.minimum = 1, .maximum = k_grid_max, .help = "number of control points along y"});
  world.length_mm(
      "height_sd_mm", table.height_sd_m,
      {.minimum = 0,
       .maximum = 1000,
       .help = "standard deviation of control point heights; the standard deviation of the "
               "surface's heights is 0.48 times as large"});
  bind_range(world, "restitution", table.restitution, 1);
  bind_range(world, "friction", table.friction, 10);
  if (!world.all_valid({"spacing_mm", "height_sd_mm"})) return;
  constexpr double k_steepest = 0.5;
  if (table.height_sd_m > k_steepest * table.spacing_m) {
    world.error("height_sd_mm", fmt::format("must be at most {:.6g} (half of spacing_mm)",
                                            1e3 * k_steepest * table.spacing_m));
  }
  for (const DieStart& start : p.dice) {
    if (start.start_s >= p.time_max_s && world.valid("time_max_s"))
      world.error("time_max_s", "must be greater than start_s of every [[world.die]] table");
  }
}

// Goals.

struct GoalKeys {
  Goal goal;
  std::uint32_t die = 1;
};

struct GoalPlace {
  std::string name;  ///< "[constraint.place]"
  std::uint32_t line = 0;
};

struct GoalBinder {
  Binder& constraint;
  const WorldParameters& world;
  std::vector<Goal>& goals;
  std::vector<GoalPlace> places = {};  ///< of `goals`

  void bind_die(Binder& table, GoalKeys& keys) const {
    table.integer("die", keys.die,
                  {.minimum = 1, .maximum = k_dice_max, .help = "number of the die"});
    keys.goal.die = keys.die - 1;
    if (table.valid("die") && keys.die > world.dice.size()) {
      keys.goal.die = 0;
      table.error("die", fmt::format("must be at most {}, the number of dice in [world]",
                                     world.dice.size()));
    }
  }
  void bind_time(Binder& table, GoalKeys& keys) const {
    table.optional_number("at_s", keys.goal.at_s,
                          {.minimum = 0,
                           .maximum = 100,
                           .unit = "s",
                           .help = "time of the goal; default: the end of the simulation"});
    if (keys.goal.at_s && *keys.goal.at_s > world.time_max_s) {
      keys.goal.at_s.reset();
      table.error("at_s", "must be at most time_max_s of [world]");
    }
  }
  static void bind_lengths(Binder& table, GoalKeys& keys, double tolerance_min) {
    table.length_mm("sigma_mm", keys.goal.sigma,
                    {.minimum = 0.001, .maximum = k_far_mm, .help = k_sigma_help});
    table.length_mm("tolerance_mm", keys.goal.tolerance,
                    {.minimum = tolerance_min, .maximum = k_far_mm, .help = k_tolerance_help});
  }
  static void bind_angles(Binder& table, GoalKeys& keys) {
    table.angle_deg("sigma_deg", keys.goal.sigma,
                    {.minimum = 0.001, .maximum = 360, .help = k_sigma_help});
    table.angle_deg(
        "tolerance_deg", keys.goal.tolerance,
        {.minimum = 0.001, .maximum = k_face_tolerance_max_deg, .help = k_tolerance_help});
  }

  /// Binds an array of tables. Each table is a goal, which `bind` reads. `sigma` and `tolerance`
  /// are defaults.
  void tables(std::string_view key, std::string_view help, double sigma, double tolerance,
              const std::function<void(Binder&, GoalKeys&)>& bind) {
    std::vector<GoalKeys> given;
    constraint.tables<GoalKeys>(key, given, {.count_max = k_goals_max, .help = help},
                                [&](Binder& table, GoalKeys& keys) {
                                  keys.goal.sigma = sigma;
                                  keys.goal.tolerance = tolerance;
                                  bind_die(table, keys);
                                  bind(table, keys);
                                  // A call without a table only registers keys.
                                  if (table.line() == 0 || !table.is_sound()) return;
                                  refuse_contradictions(table, keys.goal);
                                  goals.push_back(keys.goal);
                                  places.push_back({table.section_name(), table.line()});
                                });
  }

  void refuse_contradictions(Binder& table, const Goal& goal) const {
    for (std::size_t i = 0; i < goals.size(); ++i) {
      const std::string words = contradiction_of(goals[i], goal, world.side_m);
      if (words.empty()) continue;
      table.error(
          "die", fmt::format("{} (see also line {}, [{}])", words, places[i].line, places[i].name));
      return;
    }
  }

  void bind_places();
  void bind_directions();
  void bind_motion();
};

void GoalBinder::bind_places() {
  const NumberOptions place{
      .minimum = -k_far_mm, .maximum = k_far_mm, .help = "position of the centre"};
  NumberOptions bound = place;
  bound.help = "bound of the centre's position";
  tables("place", "goal: position of a die's centre", 0.0025, 0.005,
         [&](Binder& table, GoalKeys& keys) {
           Place wanted;
           table.length_mm("x_mm", wanted.centre_m.x(), place);
           table.length_mm("y_mm", wanted.centre_m.y(), place);
           bind_lengths(table, keys, 0.001);
           bind_time(table, keys);
           keys.goal.wanted = wanted;
         });
  tables("region", "goal: rectangle that contains a die's centre", 0.005, 0,
         [&](Binder& table, GoalKeys& keys) {
           Region region{.low_m = {-0.05, -0.05}, .high_m = {0.05, 0.05}};
           table.length_mm("x_low_mm", region.low_m.x(), bound);
           table.length_mm("x_high_mm", region.high_m.x(), bound);
           table.length_mm("y_low_mm", region.low_m.y(), bound);
           table.length_mm("y_high_mm", region.high_m.y(), bound);
           bind_lengths(table, keys, 0);
           bind_time(table, keys);
           keys.goal.wanted = region;
           if (region.low_m.x() > region.high_m.x())
             table.error("x_high_mm", "must be at least x_low_mm");
           if (region.low_m.y() > region.high_m.y())
             table.error("y_high_mm", "must be at least y_low_mm");
         });
}

void GoalBinder::bind_directions() {
  constexpr double k_5_rad = 0.087266462599716474;  // 5, 10 and 20 degrees
  constexpr double k_10_rad = 0.17453292519943295;
  constexpr double k_20_rad = 0.3490658503988659;
  tables("face", "goal: top face of a die", k_10_rad, k_20_rad, [&](Binder& table, GoalKeys& keys) {
    std::uint32_t up = 6;
    table.integer(
        "up", up,
        {.minimum = 1, .maximum = k_faces, .help = "face on top; opposite faces add up to 7"});
    bind_angles(table, keys);
    bind_time(table, keys);
    keys.goal.wanted = FaceDirection{.face = up, .direction = Vec3(0, 0, 1)};
  });
  tables("yaw", "goal: direction of a side face of a die", k_5_rad, k_10_rad,
         [&](Binder& table, GoalKeys& keys) {
           std::uint32_t face = 1;
           double yaw_rad = 0;
           table.integer("face", face,
                         {.minimum = 1, .maximum = k_faces, .help = "number of the face"});
           table.angle_deg("yaw_deg", yaw_rad,
                           {.minimum = -360,
                            .maximum = 360,
                            .help = "azimuth of the face's outward normal, from the x axis towards "
                                    "the y axis"});
           bind_angles(table, keys);
           bind_time(table, keys);
           const math::SinCos yaw = math::sincos(yaw_rad);
           keys.goal.wanted = FaceDirection{.face = face, .direction = Vec3(yaw.cos, yaw.sin, 0)};
         });
  tables("orientation", "goal: orientation of a die", k_5_rad, k_10_rad,
         [&](Binder& table, GoalKeys& keys) {
           std::array<double, 4> q{1, 0, 0, 0};
           bind_quaternion(table, "quaternion of the orientation", q);
           if (!is_rotation(q)) {
             table.error("qw", "the quaternion is too small to be a rotation");
           } else {
             keys.goal.wanted = Turn{math::normalized(Quat(q[0], q[1], q[2], q[3]))};
           }
           bind_angles(table, keys);
           bind_time(table, keys);
         });
}

void GoalBinder::bind_motion() {
  const auto scale = [](Binder& table, GoalKeys& keys, const std::string& unit, const char* shown,
                        double tolerance_min) {
    table.number("sigma_" + unit, keys.goal.sigma,
                 {.minimum = 1e-6, .maximum = 100, .unit = shown, .help = k_sigma_help});
    table.number(
        "tolerance_" + unit, keys.goal.tolerance,
        {.minimum = tolerance_min, .maximum = 100, .unit = shown, .help = k_tolerance_help});
  };
  tables("velocity", "goal: velocity of a die", 0.05, 0.1, [&](Binder& table, GoalKeys& keys) {
    Vec3 velocity_mps{0, 0, 0};
    for (int k = 0; k < 3; ++k)
      table.number(
          fmt::format("{}_mps", "xyz"[k]), velocity_mps[k],
          {.minimum = -100, .maximum = 100, .unit = "m/s", .help = "velocity of the centre"});
    scale(table, keys, "mps", "m/s", 1e-6);
    bind_time(table, keys);
    keys.goal.wanted = Velocity{velocity_mps};
  });
  tables("before", "goal: time by which a die comes to rest", 0.1, 0,
         [&](Binder& table, GoalKeys& keys) {
           double time_s = 2;
           table.number("time_s", time_s,
                        {.minimum = 0,
                         .maximum = 100,
                         .unit = "s",
                         .help = "maximum time from the first release until the die comes to "
                                 "rest"});
           scale(table, keys, "s", "s", 0);
           keys.goal.wanted = RestBefore{time_s};
           const auto first = std::ranges::min_element(world.dice, {}, &DieStart::start_s);
           const double start_s = world.dice.at(keys.goal.die).start_s - first->start_s;
           if (time_s + keys.goal.tolerance < start_s)
             table.error("time_s",
                         fmt::format("too early: die {} starts {:.3g} s after the first die",
                                     keys.die, start_s));
         });
}

/// Checks face goals against each other and against the dice's starts.
void check_faces(Binder& constraint, const Parameters& p) {
  for (std::uint32_t die = 0; die < p.world.dice.size() && p.numbering == Numbering::free; ++die) {
    std::vector<const Goal*> of_faces;
    for (const Goal& goal : p.goals) {
      if (goal.die == die && goal.is_of_faces()) of_faces.push_back(&goal);
    }
    if (of_faces.empty()) continue;
    if (p.world.dice[die].orientation == StartOrientation::fixed)
      constraint.error("numbering",
                       fmt::format("must be \"fixed\": die {} has a fixed initial orientation, so "
                                   "its faces can't be numbered after the throw",
                                   die + 1));
    if (std::ranges::any_of(of_faces,
                            [&](const Goal* goal) { return goal->at_s != of_faces.front()->at_s; }))
      constraint.error("numbering",
                       fmt::format("must be \"fixed\": die {} has face goals at several times, and "
                                   "the die needs one numbering for all of them",
                                   die + 1));
  }
}

void bind_proposal(Binder& sampler, ProposalParameters& p) {
  sampler.shares(
      {{"change_all", p.change_all, "share of proposals that redraw everything"},
       {"change_die", p.change_die, "share of proposals that redraw the start of one die"},
       {"change_start", p.change_start,
        "share of proposals that change one component of a die's start"},
       {"change_control", p.change_control,
        "share of proposals that change a random control point"},
       {"change_contact", p.change_contact,
        "share of proposals that change a control point at a collision"}});
  sampler.length_mm("position_step_mm", p.position_m,
                    {.minimum = 1e-6, .maximum = 1000, .help = k_step_help});
  const auto step = [&](std::string_view key, double& value, std::string_view unit,
                        double maximum) {
    sampler.number(key, value,
                   {.minimum = 1e-9, .maximum = maximum, .unit = unit, .help = k_step_help});
  };
  step("velocity_step_mps", p.velocity_mps, "m/s", 100);
  step("spin_step_radps", p.spin_radps, "rad/s", 1000);
  sampler.angle_deg("turn_step_deg", p.turn_rad,
                    {.minimum = 1e-6,
                     .maximum = 360,
                     .help = "standard deviation of rotation steps, before halvings"});
  sampler.length_mm("height_step_mm", p.height_m,
                    {.minimum = 1e-6,
                     .maximum = 1000,
                     .help = "standard deviation of changes of a point's height, before halvings"});
  step("restitution_step", p.restitution, "", 1);
  step("friction_step", p.friction, "", 10);
  sampler.integer("halvings", p.halvings,
                  {.minimum = 0,
                   .maximum = 40,
                   .help = "maximum number of halvings of a step; every number from 0 to this "
                           "maximum is equally likely"});
}

void bind(request::WorldSections& sections, Parameters& parameters) {
  bind_world(sections.world, parameters.world);
  sections.constraint.choice<Numbering>("numbering", parameters.numbering, k_numbering_names,
                                        "free: faces are numbered after the throw to fit the "
                                        "goals best; fixed: faces are numbered before it");
  GoalBinder goals{sections.constraint, parameters.world, parameters.goals};
  goals.bind_places();
  goals.bind_directions();
  goals.bind_motion();
  check_faces(sections.constraint, parameters);
  bind_proposal(sections.sampler, parameters.proposal);
}

/// Chooses the sampler if the request doesn't name one (docs/SAMPLING, "Without a sampler").
/// Measured in docs/MEASUREMENTS.
void serve_best(request::WorldSections& sections, request::SamplerParameters& sampling,
                const request::StopRule& stop, Parameters& parameters) {
  constexpr std::uint32_t k_relax_scans = 2;
  request::Settled settled(sections.sampler, sampling);
  const auto dice = static_cast<std::uint32_t>(parameters.world.dice.size());
  if (stop.takes) {
    settled.relax(10 * dice, k_relax_scans);
  } else if (stop.odds) {
    settled.method(request::Method::sequential, "sequential");
    settled.count("particles", sampling.particles, 32);
  } else {
    // Rounds are short, because temperatures and step sizes adapt soon.
    settled.method(request::Method::parallel_tempering, "parallel_tempering");
    settled.chains(2, 20, dice == 1 ? 1 : 3 * dice);
  }
}

}  // namespace

request::WorldBinding request_binding() {
  return request::bind_world<Parameters>(
      "dice", "dice are thrown on a bumpy table and come to rest as requested", &bind, &serve_best);
}

}  // namespace sleight::worlds::dice
