#include "worker/worlds/spelling/spelling.h"

#include <cmath>
#include <limits>
#include <numbers>

#include "common/base/check.h"
#include "worker/physics/marbles/marbles.h"
#include "worker/worlds/failures/failure_of.h"
#include "worker/worlds/spelling/traps.h"

namespace sleight::worlds::spelling {
namespace {

/// After the last drop, the simulation tests at this interval whether all balls stay.
constexpr double k_look_every_s = 0.1;
/// The partitions' bounding volumes have room for offsets up to this many standard deviations.
constexpr double k_slack_sds = 5;
/// Limit of events. Ten balls take about 300 events together until the outcome is decided. If a box
/// has no room for a ball, the wedged ball may have half a million events. If a ball leans on
/// another ball and is nearly in balance, it has thousands of events per second. A run to rest has
/// more events, so its limit is larger.
constexpr std::uint64_t k_work_per_ball_max = 10'000;
constexpr std::uint64_t k_work_to_rest = 5;
/// Minimum distance of dropped balls from the walls.
constexpr double k_clear_m = 1e-6;
/// Maximum steps of a walk that simulates balls alone. If walks are accepted often enough only
/// below half this length, single steps do better.
constexpr double k_solo_walk_max = 60;
constexpr double k_walk_scale_min = 0.5;
constexpr double k_impossible = -std::numeric_limits<double>::infinity();

/// Observes a ball now. A simulation recorded the ball's history; `known` is the ball at this tick
/// of that simulation, or null.
Seen seen_of(physics::Marbles& marbles, std::uint32_t ball, const Seen* known) {
  if (const physics::MarbleHistory* history = marbles.replayed({ball})) {
    // An observation may show a ball that was left alone. This observation holds only if the ball's
    // history has left the ball alone by this tick. Otherwise the ball isn't alone now, because of
    // other balls' places.
    if (known != nullptr && (!known->was_alone || history->is_alone_at(marbles.now())))
      return *known;
    if (history->stays && history->last.tick <= marbles.now()) {
      const physics::Segment& segment = history->last.marble.segment;
      return {
          .ball = {.centre_m = segment.flight.position_m,
                   .twist = {segment.flight.velocity_mps, segment.flight.angular_velocity_radps},
                   .rests = segment.mode == physics::MotionMode::resting},
          .was_alone = history->last.marble.suspended};
    }
    marbles.stop_replay({ball});
  }
  const physics::Segment& segment = marbles.segment({ball});
  const bool rests = segment.mode == physics::MotionMode::resting;
  // A suspended ball is trapped. The ball's state is from the moment of suspension.
  if (marbles.is_suspended({ball})) {
    return {.ball = {.centre_m = segment.flight.position_m,
                     .twist = {segment.flight.velocity_mps, segment.flight.angular_velocity_radps},
                     .rests = rests},
            .was_alone = true};
  }
  return {.ball = {.centre_m = marbles.position_m({ball}),
                   .twist = marbles.twist({ball}),
                   .rests = rests}};
}

class Looks {
 public:
  /// `known_state` and `known_history` are a similar state and its history, or null. Observations
  /// are stored in `kept`, unless it is null.
  Looks(const State& state, const State* known_state, const SpellingHistory* known_history,
        SpellingHistory* kept)
      : state_(state), known_state_(known_state), known_history_(known_history), kept_(kept) {
    balls_.reserve(state.active_count());
    if (kept_ == nullptr || known_history_ == nullptr) return;
    kept_->looks.reserve(known_history_->looks.size());
    kept_->seen.reserve(known_history_->seen.size());
  }
  void look(physics::Marbles& marbles) {
    std::span<const Seen> known_look;
    if (known_history_ != nullptr) known_look = known_history_->seen_at(marbles.now());
    balls_.clear();
    for (std::uint32_t ball = 0; ball < state_.active.size(); ++ball) {
      if (state_.active[ball] == 0) continue;
      // Test whether the known state was observed at this tick, and whether this ball was active in
      // it.
      const bool is_known = !known_look.empty() && known_state_->active[ball] != 0;
      const Seen* before = is_known ? &known_look[known_state_->active_before(ball)] : nullptr;
      const Seen seen = seen_of(marbles, ball, before);
      balls_.push_back(seen.ball);
      if (kept_ != nullptr) kept_->seen.push_back(seen);
    }
    if (kept_ != nullptr) kept_->looks.push_back(marbles.now());
  }
  const std::vector<Traps::Ball>& balls() const { return balls_; }

 private:
  const State& state_;
  const State* known_state_;
  const SpellingHistory* known_history_;
  SpellingHistory* kept_;
  std::vector<Traps::Ball> balls_;
};

/// Leaves trapped balls alone. Valid until `traps` is destroyed.
physics::MarbleConfinement within(const Traps& traps) {
  return [&traps](physics::BodyId, const Vec3& centre_m,
                  const physics::Twist& twist) -> std::optional<physics::Box> {
    const auto place = traps.of(centre_m, twist);
    return place ? std::optional(place->box) : std::nullopt;
  };
}

/// Returns the bin that a helped ball fills, or k_fills_none if the ball isn't helped.
std::int16_t filled_with_help(const Outcome& outcome, const SoloBalls::Outcome& solo,
                              std::size_t ball) {
  return outcome.filling[ball] == solo.alone[ball] ? k_fills_none : outcome.filling[ball];
}

}  // namespace

Spelling::Spelling(const Parameters& parameters, Replays replays)
    : parameters_(parameters),
      replays_(replays),
      bins_(parameters.world, parameters.pattern.columns, parameters.pattern.rows),
      influence_(bins_, new_geometry()->near().statics()),
      prior_{.vertices = bins_.vertex_count(),
             .balls = parameters.pattern.count(),
             .vertex_sd_m = parameters.world.vertex_sd_m} {
  const double inset_m = 0.5 * parameters_.world.ball_diameter_m + k_clear_m;
  prior_.drop_half_m = {bins_.half_m().x() - inset_m, bins_.half_m().y() - inset_m};
  CHECK_GT(prior_.drop_half_m.x(), 0);
  CHECK_GT(prior_.drop_half_m.y(), 0);

  const Vec2& half_m = prior_.drop_half_m;
  for (std::uint32_t row = 0; row < bins_.rows(); ++row) {
    for (std::uint32_t column = 0; column < bins_.columns(); ++column) {
      const bool designated = parameters_.pattern.at(column, bins_.rows() - 1 - row);
      numbers_.push_back(designated ? static_cast<std::int16_t>(windows_.bins()) : k_fills_none);
      if (!designated) continue;
      const Vec3 floor_m = bins_.floor_middle_m({column, row});
      const Vec2 middle_m(floor_m.x(), floor_m.y());
      windows_.add(middle_m, parameters_.world.bin_m, half_m);
      middles_m_.push_back(middle_m);
    }
  }
}

std::int16_t Spelling::number_below(const Vec2& place_m) const {
  const std::optional<Bin> bin = bins_.bin_at(Vec3(place_m.x(), place_m.y(), 0));
  return bin ? numbers_[std::size_t{bin->row} * bins_.columns() + bin->column] : k_fills_none;
}

sampling::Proposal<State> Spelling::propose(const State& state, const Filling* filling,
                                            std::span<const double> scales,
                                            random::Stream& stream) const {
  const ProposalParameters& p = parameters_.proposal;
  const Kind kind = drawn_kind(p, stream);
  sampling::Proposal<State> proposal{.candidate = state};
  if (kind != Kind::scatter_ball && kind != Kind::aim_ball) {
    proposal = propose_of(kind, prior_, p, state, scales, stream);
  } else if (filling != nullptr) {
    const auto drawn = kind == Kind::aim_ball
                           ? aim_ball(prior_, windows_, p, state, *filling, stream)
                           : scatter_ball(prior_, windows_, p, state, *filling, stream);
    if (drawn) proposal = *drawn;
  }
  proposal.kind = static_cast<std::uint32_t>(kind);
  return proposal;
}

double Spelling::log_q_ratio(const State& state, const Filling* filling,
                             const sampling::Proposal<State>& proposal,
                             const Filling* candidate_filling) const {
  if (filling == nullptr || candidate_filling == nullptr) return k_impossible;
  const bool aimed = proposal.kind == static_cast<std::uint32_t>(Kind::aim_ball);
  const auto ratio = aimed ? aim_log_q_ratio : scatter_log_q_ratio;
  return ratio(prior_, windows_, parameters_.proposal, state, *filling, proposal.candidate,
               *candidate_filling);
}

Anchor Spelling::draw_anchor(const State& state, const Outcome& outcome,
                             const SoloBalls::Outcome& solo, double keep,
                             random::Stream& stream) const {
  if (keep == 0 || !outcome.is_animation()) return {};
  Anchor anchor{.bins = Filling(balls(), k_fills_none),
                .drops_m = std::vector<Vec2>(balls(), Vec2(0, 0))};
  for (std::size_t ball = 0; ball < balls(); ++ball) {
    const std::int16_t helped = filled_with_help(outcome, solo, ball);
    if (helped == k_fills_none || (keep != 1 && stream.uniform() >= keep)) continue;
    anchor.bins[ball] = helped;
    anchor.drops_m[ball] = state.drops_m[ball];
  }
  return anchor;
}

double Spelling::log_anchor_probability(const Anchor& anchor, const Outcome& outcome,
                                        const SoloBalls::Outcome& solo, double keep) const {
  if (keep == 0) return 0;
  if (outcome.is_animation() == anchor.bins.empty()) return k_impossible;
  if (anchor.bins.empty()) return 0;
  std::uint32_t kept = 0;
  std::uint32_t left = 0;
  for (std::size_t ball = 0; ball < balls(); ++ball) {
    const std::int16_t helped = filled_with_help(outcome, solo, ball);
    if (anchor.bins[ball] == k_fills_none) {
      if (helped != k_fills_none) ++left;
    } else if (anchor.bins[ball] == helped) {
      ++kept;
    } else {
      return k_impossible;
    }
  }
  if (keep == 1) return left == 0 ? 0 : k_impossible;
  return kept * math::log(keep) + left * math::log(1 - keep);
}

sampling::SurrogateSteps Spelling::surrogate_steps(std::span<const double> scales) const {
  const std::uint32_t asked = parameters_.proposal.solo_steps;
  if (asked == 0) return {};
  const auto walk_kind = static_cast<std::uint32_t>(Kind::solo_walk);
  const double scale = scales.empty() ? 1 : scales[walk_kind];
  const double walk =
      scale < k_walk_scale_min ? 0 : std::clamp(asked * scale, 1.0, k_solo_walk_max);
  return {.walk = static_cast<std::uint32_t>(walk),
          .single = asked,
          .walk_kind = walk_kind,
          .single_kind = static_cast<std::uint32_t>(Kind::solo_step)};
}

Spelling::Alone Spelling::fall_alone(std::span<const Vec3> offsets_m, const Vec2& drop_m) const {
  const State state{
      .offsets_m = {offsets_m.begin(), offsets_m.end()}, .active = {1}, .drops_m = {drop_m}};
  const Outcome outcome = simulated(state, Until::decided);
  if (outcome.end == End::impossible) return {.possible = false};
  if (outcome.is_animation()) return {.bin = outcome.filling.front()};
  // Report the failure with a whole state, because people can simulate a whole state again. Only
  // the first ball is active.
  State whole = state;
  whole.active.resize(balls(), 0);
  whole.drops_m.resize(balls(), Vec2(0, 0));
  return {.failure = std::make_shared<const plan::SimulationFailure>(
              plan::SimulationFailure{.kind = outcome.failure->kind,
                                      .message = outcome.failure->message,
                                      .state = encode(whole)})};
}

std::optional<physics::Scene> Spelling::scene(const State& state) const {
  auto surface = bins_.surface(state.offsets_m);
  if (!surface) return std::nullopt;
  return scene_in(state, std::move(surface), Bodies::active);
}

physics::Scene Spelling::scene_in(const State& state,
                                  std::shared_ptr<const physics::TriangleMesh> surface,
                                  Bodies bodies) const {
  const WorldParameters& world = parameters_.world;
  physics::Scene scene;
  scene.gravity_mps2 = {0, 0, -world.gravity_mps2};
  scene.contacts =
      physics::ContactTable(1, {.restitution = world.restitution, .friction = world.friction});
  const double fall_mps = std::sqrt(world.gravity_mps2 * world.ball_diameter_m);
  scene.slow = {.separation_speed_mps = world.bounce_end * fall_mps,
                .rest_speed_mps = world.rest_speed * fall_mps,
                .rest_time_s = world.rest_time * fall_mps / world.gravity_mps2};
  scene.meshes.push_back(
      {.name = "bins", .mesh = std::move(surface), .slack_m = k_slack_sds * world.vertex_sd_m});
  scene.convexes.assign(bins_.walls().begin(), bins_.walls().end());
  scene.planes.push_back(bins_.ground());
  const double radius_m = 0.5 * world.ball_diameter_m;
  const double mass_kg =
      world.density_kgpm3 * 4 / 3 * std::numbers::pi * radius_m * radius_m * radius_m;
  for (std::size_t ball = 0; ball < state.active.size(); ++ball) {
    const bool is_active = state.active[ball] != 0;
    if (!is_active && bodies == Bodies::active) continue;
    const Vec2& drop_m = state.drops_m[ball];
    physics::BodyDescription body;
    body.name = "ball " + std::to_string(ball);
    body.shape = physics::Sphere{.radius_m = radius_m};
    body.inertia = physics::solid_ball_inertia(mass_kg, radius_m);
    body.start.pose.position_m = {drop_m.x(), drop_m.y(), world.drop_height_m + radius_m};
    body.start_tick = is_active ? start_of(ball) : physics::k_never;
    scene.bodies.push_back(std::move(body));
  }
  return scene;
}

physics::Tick Spelling::start_of(std::size_t ball) const {
  return physics::Tick{} +
         physics::ticks_after(parameters_.world.drop_interval_s * static_cast<double>(ball));
}

physics::Tick Spelling::limit_after(physics::Tick last_start) const {
  return last_start + physics::ticks_after(parameters_.world.time_limit_s);
}

template <class Engine, class AllStay>
std::optional<physics::SceneError> Spelling::run(physics::Tick last_start, Engine& engine,
                                                 const AllStay& all_stay) const {
  const physics::Tick limit = limit_after(last_start);
  for (physics::Tick end = last_start; end < limit;) {
    end = std::min(limit, end + physics::ticks_after(k_look_every_s));
    if (auto error = engine.run_until(end)) return error;
    if (all_stay()) return std::nullopt;
  }
  return std::nullopt;
}

std::unique_ptr<BoxGeometry> Spelling::new_geometry() const {
  // Use any ball, since all balls have the same properties.
  State state{.offsets_m = std::vector<Vec3>(bins_.vertex_count(), Vec3::Zero()),
              .active = {1},
              .drops_m = {Vec2(0, 0)}};
  auto mesh = bins_.unmoved_surface();
  return std::make_unique<BoxGeometry>(scene_in(state, mesh, Bodies::active), mesh,
                                       bins_.vertex_count());
}

State Spelling::draw_throw(random::Stream& stream) const {
  State state = draw_prior(stream);
  for (std::size_t ball = 0; ball < balls(); ++ball) {
    state.active[ball] = 1;
    state.drops_m[ball] = prior_.draw_drop(stream);
  }
  return state;
}

Outcome Spelling::simulate(const State& state) const {
  return simulated(state, Until::decided);
}

Outcome Spelling::simulate_from(const State& candidate, const State& state,
                                const Outcome& outcome) const {
  // If the candidate doesn't resemble the state, nothing can be replayed. The candidate then stores
  // no history, because most such candidates are rejected. After an acceptance, the next candidate
  // that resembles the new state stores a history.
  if (replays_ == Replays::no || !resembles(candidate, state)) return simulate(candidate);
  if (!outcome.history) return simulated(candidate, Until::decided, true);
  const Known known{.state = state, .history = *outcome.history};
  return simulated(candidate, Until::decided, true, &known);
}

Outcome Spelling::simulate_to_rest(const State& state) const {
  return simulated(state, Until::rest);
}

Outcome Spelling::simulated(const State& state, Until until, bool records,
                            const Known* known) const {
  const BoxGeometries::Loan geometry =
      geometries_->borrow(state.offsets_m, [&] { return new_geometry(); });
  if (!geometry->move_to(bins_, state.offsets_m)) return {.end = End::impossible};
  if (state.active_count() == 0) return judged({}, 0);
  std::optional<Outcome> result;
  if (known != nullptr && known->history.border_m == geometry->near().statics().border_m(0))
    result = simulated_in(*geometry, state, until, records, known);
  if (!result) result = simulated_in(*geometry, state, until, records, nullptr);
  return *std::move(result);
}

std::optional<Outcome> Spelling::simulated_in(BoxGeometry& geometry, const State& state,
                                              Until until, bool records, const Known* known) const {
  const physics::Scene scene = scene_in(state, geometry.mesh(), Bodies::all);
  std::size_t last = state.active.size() - 1;
  while (state.active[last] == 0)
    --last;
  const physics::Tick last_start = start_of(last);
  const Traps traps(parameters_.world, bins_, state.offsets_m);
  // Find the part of the known state's history that also holds for this state.
  physics::MarbleHistories histories;
  std::vector<physics::MarbleChange> changes;
  if (known != nullptr) {
    histories = histories_that_hold(known->history, known->state, state);
    changes = influence_.changes(known->state.offsets_m, known->history.flat_edges, state.offsets_m,
                                 influence_.flat_edges(*geometry.mesh()));
  }
  physics::Marbles& marbles = geometry.marbles();
  const std::uint64_t work_max =
      (until == Until::rest ? k_work_to_rest : 1) * k_work_per_ball_max * state.active_count();
  marbles.start(scene, geometry.near(), limit_after(last_start),
                until == Until::decided ? within(traps) : physics::MarbleConfinement{}, work_max,
                {.histories = known != nullptr ? &histories : nullptr,
                 .changes = changes,
                 // Traps depend on the partition vertices too.
                 .confinement_differs = !changes.empty(),
                 .records = records});
  if (const auto error = marbles.run_until(physics::Tick{})) {
    if (marbles.is_replay_void()) return std::nullopt;
    return stopped(*error, state);
  }
  auto history = records ? std::make_shared<SpellingHistory>() : nullptr;
  Looks looks(state, known != nullptr ? &known->state : nullptr,
              known != nullptr ? &known->history : nullptr, history.get());
  const auto error = run(last_start, marbles, [&] {
    looks.look(marbles);
    return until == Until::rest ? std::ranges::all_of(looks.balls(), &Traps::Ball::rests)
                                : traps.all_stay(looks.balls());
  });
  if (marbles.is_replay_void()) return std::nullopt;
  if (error) return stopped(*error, state);

  Outcome outcome = came_to(state, looks.balls(), traps);
  outcome.end_s = physics::seconds(marbles.now() - physics::Tick{});
  if (history) {
    history->histories = marbles.histories();
    history->flat_edges = influence_.flat_edges(*geometry.mesh());
    history->border_m = geometry.near().statics().border_m(0);
    history->simulated = marbles.counts().work();
    outcome.history = std::move(history);
  }
  return outcome;
}

Outcome Spelling::came_to(const State& state, std::span<const Traps::Ball> balls,
                          const Traps& traps) const {
  std::vector<Staying> staying;
  std::size_t nth = 0;
  for (std::uint32_t ball = 0; ball < state.active.size(); ++ball) {
    if (state.active[ball] == 0) continue;
    const Traps::Ball& seen = balls[nth++];
    if (seen.rests || traps.of(seen.centre_m, seen.twist))
      staying.push_back({.ball = ball, .centre_m = seen.centre_m});
  }
  const auto others = static_cast<std::uint32_t>(balls.size() - staying.size());
  Outcome outcome = judged(staying, others);
  outcome.end = others == 0 ? End::settled : End::time_limit;
  return outcome;
}

Outcome Spelling::stopped(const physics::SceneError& error, const State& state) {
  plan::FailurePointer failure = failure_of(error, spelling::encode(state));
  return {.end = failure ? End::failed : End::impossible, .failure = std::move(failure)};
}

Animation Spelling::animate(const State& state) const {
  Animation animation;
  for (std::uint32_t ball = 0; ball < balls(); ++ball) {
    if (state.active[ball] != 0) animation.balls.push_back(ball);
  }
  if (animation.balls.empty()) return animation;
  const auto scene = this->scene(state);
  CHECK(scene.has_value());
  physics::Simulation simulation = physics::Simulation::start(*scene, {}).value();
  const auto error = run(scene->bodies.back().start_tick, simulation, [&] {
    bool all_rest = true;
    for (std::uint32_t body = 0; body < scene->bodies.size(); ++body)
      all_rest = all_rest && simulation.mode({body}) == physics::MotionMode::resting;
    return all_rest;
  });
  CHECK(!error);
  animation.recording = simulation.recording();
  return animation;
}

std::vector<int> Spelling::balls_of_bins(const State& state) const {
  const Filling filling = simulated(state, Until::decided).filling;
  std::vector<int> balls;
  for (const std::int16_t number : numbers_) {
    const auto ball = std::ranges::find(filling, number);
    const bool is_filled = number != k_fills_none && ball != filling.end();
    balls.push_back(is_filled ? static_cast<int>(ball - filling.begin()) : -1);
  }
  return balls;
}

Outcome Spelling::judged(std::span<const Staying> staying, std::uint32_t others) const {
  Outcome outcome{.elsewhere = others, .filling = Filling(balls(), k_fills_none)};
  for (const auto& [ball, centre_m] : staying) {
    const bool is_low = centre_m.z() > 0 && centre_m.z() < parameters_.world.partition_height_m;
    const std::int16_t bin = is_low ? number_below(Vec2(centre_m.x(), centre_m.y())) : k_fills_none;
    if (bin != k_fills_none && std::ranges::find(outcome.filling, bin) == outcome.filling.end()) {
      outcome.filling[ball] = bin;
      ++outcome.filled;
    } else {
      ++outcome.elsewhere;
    }
  }
  return outcome;
}

double Spelling::log_constraint(const Outcome& outcome) const {
  if (!outcome.is_animation()) return k_impossible;
  return outcome.filled * parameters_.constraint.log_lambda;
}

std::vector<double> Spelling::outcome_values(const Outcome& outcome) const {
  return {static_cast<double>(outcome.filled), static_cast<double>(outcome.elsewhere),
          outcome.end_s, static_cast<double>(outcome.end)};
}

bool Spelling::satisfied(const Outcome& outcome) const {
  return outcome.is_animation() && outcome.filled == balls() && outcome.elsewhere == 0;
}

}  // namespace sleight::worlds::spelling
