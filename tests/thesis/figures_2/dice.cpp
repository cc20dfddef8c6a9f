#include "tests/thesis/figures_2/dice.h"

#include <fmt/format.h>

#include <map>
#include <memory>
#include <utility>

#include "clients/cli/dice_figures.h"
#include "common/base/check.h"
#include "common/base/clock.h"
#include "common/request/direction_request.h"
#include "common/request/world_parameters.h"
#include "worker/run/catalogue.h"
#include "worker/worlds/dice/dice.h"
#include "worker/worlds/dice/request.h"

namespace sleight::thesis {
namespace {

namespace dice = worlds::dice;

constexpr double k_mm_per_m = 1000;

/// The motion of a state's only die.
cli::DieMotion motion_of(const dice::Dice& world, base::BytesView state, std::uint32_t nth) {
  const auto decoded = world.decode(state);
  CHECK(decoded.has_value());
  const dice::Animation animation = world.animate(*decoded);
  const math::Quat numbered =
      dice::rotation_of_numbering(animation.outcome.judgement.numberings.front());
  cli::DieMotion motion(nth);
  for (const auto& [segment, cause] : animation.recording.segments({0})) {
    const physics::FreeFlight& flight = segment.flight;
    motion.append({.start_s = physics::seconds(flight.begin - physics::Tick{}),
                   .position_mm = k_mm_per_m * flight.position_m,
                   .velocity_mmps = k_mm_per_m * flight.velocity_mps,
                   .acceleration_mmps2 = k_mm_per_m * flight.acceleration_mps2,
                   .orientation = math::composed(flight.orientation, numbered),
                   .spin_radps = flight.angular_velocity_radps});
  }
  return motion;
}

/// The first state at inverse temperature 1 that is satisfied, and what it took.
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
  run::Catalogue catalogue;
  const request::DirectionRequest request =
      request::read_request(text, "figure 2.13", catalogue.bindings()).value();
  const run::WorldEntry& entry = catalogue.world("dice");
  const std::unique_ptr<plan::Plan> plan = run::make_plan(request, entry);
  const std::unique_ptr<plan::UnitWorker> worker = entry.make_worker(request);
  const base::SteadyClock clock;
  const double begin_s = clock.now_s();
  const std::optional<base::Bytes> state = first_satisfying(*plan, *worker, die);
  die.elapsed_s = clock.now_s() - begin_s;
  if (state) {
    const dice::Dice world(request::world_parameters(text, &dice::request_binding).value());
    die.motion = motion_of(world, *state, nth);
  }
  return die;
}

plot::Figure dice_composite(const std::vector<ThrownDie>& dice, const DiceOptions& options) {
  const worlds::dice::WorldParameters world;
  cli::DiceScene scene{.dice = dice.size(),
                       .side_mm = k_mm_per_m * world.side_m,
                       .spacing_mm = k_mm_per_m * world.table.spacing_m};
  cli::DiceAnimation animation{.title = "a composite of single animations", .dice = {}};
  for (std::size_t i = 0; i < dice.size(); ++i) {
    scene.places.push_back(
        {.die = i, .centre_mm = dice[i].wish.place_mm, .tolerance_mm = options.tolerance_mm});
    if (dice[i].motion) animation.dice.push_back(*dice[i].motion);
  }
  return cli::dice_figure("Six dice, each thrown by itself onto a table of its own", scene,
                          {animation});
}

}  // namespace sleight::thesis
