#include "tests/thesis/figures_2/dice.h"

#include <fmt/format.h>

#include <map>
#include <memory>
#include <utility>

#include "clients/pictures/animation_figures.h"
#include "common/base/check.h"
#include "common/base/clock.h"
#include "common/motion/path.h"
#include "common/request/direction_request.h"
#include "common/scene/scene.h"
#include "worker/run/catalogue.h"
#include "worker/worlds/dice/dice.h"
#include "worker/worlds/dice/request.h"
#include "worker/worlds/segments/recorded_segments.h"

namespace sleight::thesis {
namespace {

namespace dice = worlds::dice;

constexpr double k_m_per_mm = 0.001;

/// Returns the motion of a state's only die. The die gets the number `nth`. All hits of the die are
/// on the table.
std::vector<motion::Segment> motion_of(const dice::Dice& world, base::BytesView state,
                                       std::uint32_t nth, std::uint32_t table) {
  const auto decoded = world.decode(state);
  CHECK(decoded.has_value());
  const dice::Animation animation = world.animate(*decoded);
  const worlds::RecordedBody die{.feature = nth,
                                 .frame = {.orientation = dice::rotation_of_numbering(
                                               animation.outcome.judgement.numberings.front())}};
  return worlds::recorded_segments(
      animation.recording, {&die, 1},
      [table](std::uint32_t, std::uint32_t) { return static_cast<std::int32_t>(table); });
}

scene::Scene composite_scene(const std::vector<ThrownDie>& dice, const DiceOptions& options) {
  const worlds::dice::WorldParameters world;
  const auto count = static_cast<std::uint32_t>(dice.size());
  scene::Scene scene;
  for (std::uint32_t i = 0; i < count; ++i) {
    scene.features.push_back({.name = fmt::format("die {}", i + 1), .twin_of = i});
    scene.parts.push_back(
        {.feature = i, .shape = scene::Shape::die, .size_m = math::Vec3::Constant(world.side_m)});
  }
  scene.features.push_back({.name = "table", .kind = scene::FeatureKind::fixed, .twin_of = count});
  scene.parts.push_back(
      {.feature = count,
       .shape = scene::Shape::surface,
       .size_m = {world.table.spacing_m * world.table.columns,
                  world.table.spacing_m * world.table.rows, world.table.spacing_m}});
  for (std::uint32_t i = 0; i < count; ++i) {
    const std::uint32_t feature = count + 1 + i;
    const double across_m = 2 * k_m_per_mm * options.tolerance_mm;
    scene.features.push_back({.name = fmt::format("place {}", i + 1),
                              .kind = scene::FeatureKind::wanted,
                              .twin_of = feature,
                              .body = static_cast<std::int32_t>(i)});
    scene.parts.push_back({.feature = feature,
                           .shape = scene::Shape::disc,
                           .size_m = {across_m, across_m, 0},
                           .position_m = {k_m_per_mm * dice[i].wish.place_mm.x,
                                          k_m_per_mm * dice[i].wish.place_mm.y, 0}});
  }
  return scene;
}

/// Runs the plan until a state at inverse temperature 1 satisfies the constraint. Returns this
/// state, and stores its cost in `die`.
std::optional<base::Bytes> first_satisfying(plan::Plan& plan, const plan::UnitWorker& worker,
                                            ThrownDie& die) {
  std::map<plan::ReplicaKey, base::Bytes> states;
  while (!plan.finished()) {
    const std::optional<plan::Unit> unit = plan.next_unit(1);
    CHECK(unit.has_value());
    base::Bytes& state = states[unit->replica];
    plan::UnitResult result = worker.run(*unit, state);
    die.simulations += result.simulations;
    for (plan::ScanRecord& record : result.scans) {
      if (record.satisfied && record.inverse_temperature == 1) {
        die.scans = plan.scans_common();
        return std::move(record.state);
      }
    }
    state = std::move(result.state_after);
    plan.consume(unit->replica, unit->first_scan, result.scans);
  }
  die.scans = plan.scans_common();
  return std::nullopt;
}

}  // namespace

std::vector<DieWish> dice_wishes() {
  return {{{-20, 40}, 1},  {{30, 40}, 2},  {{80, 40}, 3},
          {{-20, -40}, 4}, {{30, -40}, 5}, {{80, -40}, 6}};
}

std::string die_request(const DieWish& wish, std::uint64_t seed, const DiceOptions& options) {
  return fmt::format(R"([world]
name = "dice"

[constraint]
numbering = "{}"

[[constraint.place]]
x_mm = {}
y_mm = {}
sigma_mm = {}
tolerance_mm = {}

[[constraint.face]]
up = {}

[sampler]
method = "parallel_tempering"
chains = 1
seed = {}
iterations_per_scan = 4
round_scans = 50

[stop]
rounds = {}
)",
                     options.numbering_free ? "free" : "fixed", wish.place_mm.x, wish.place_mm.y,
                     0.5 * options.tolerance_mm, options.tolerance_mm, wish.face, seed,
                     options.rounds);
}

ThrownDie direct_die(std::uint32_t nth, const DieWish& wish, const DiceOptions& options) {
  ThrownDie die{.wish = wish, .seed = options.seed + nth};
  const std::string text = die_request(wish, die.seed, options);
  const run::Catalogue catalogue;
  const request::DirectionRequest request =
      request::read_request(text, "figure 2.13", catalogue.bindings()).value();
  const run::WorldEntry& entry = catalogue.world_of(request);
  const std::unique_ptr<plan::Plan> plan = run::make_plan(request, entry);
  const std::unique_ptr<plan::UnitWorker> worker = entry.make_worker(request);
  const base::SteadyClock clock;
  const double begin_s = clock.now_s();
  const std::optional<base::Bytes> state = first_satisfying(*plan, *worker, die);
  die.elapsed_s = clock.now_s() - begin_s;
  if (state) {
    const dice::Dice world(request::parameters_of<dice::Parameters>(request));
    die.motion = motion_of(world, *state, nth, static_cast<std::uint32_t>(dice_wishes().size()));
  }
  return die;
}

plot::Figure dice_composite(const std::vector<ThrownDie>& dice, const DiceOptions& options) {
  std::vector<motion::Segment> segments;
  for (const ThrownDie& die : dice)
    segments.insert(segments.end(), die.motion.begin(), die.motion.end());
  const pictures::ShownAnimation animation{
      .title = "a composite of single animations",
      .motion = motion::Animation::of(segments, dice.size()).value()};
  return pictures::animation_figure("Six dice, each thrown by itself onto a table of its own",
                                    composite_scene(dice, options), {animation});
}

}  // namespace sleight::thesis
