#include "worker/physics/simulator/simulation.h"

#include <utility>

#include "worker/physics/broad_phase/hierarchical_grid.h"
#include "worker/physics/event/tournament_queue.h"
#include "worker/physics/simulator/engine_impl.h"

namespace sleight::physics {
namespace {

std::unique_ptr<AnyEngine> engine_of(World& world, Replaying& replaying,
                                     const SimulationOptions& options,
                                     const std::optional<Takeover>& from) {
  EngineOptions chosen{.algorithm = options.algorithm,
                       .sample_every = options.sample_every,
                       .on_sample = options.on_sample};
  if (options.make_engine != nullptr)
    return options.make_engine(world, replaying, std::move(chosen), from);
  return std::make_unique<Engine<HierarchicalGrid, TournamentQueue>>(world, replaying,
                                                                     std::move(chosen), from);
}

}  // namespace

class Simulation::Impl {
 public:
  Impl(const Scene& scene, SimulationOptions chosen, std::shared_ptr<const History> history)
      : options(std::move(chosen)),
        world(scene, options.record || options.keep_history, options.segments_reserved),
        replaying(world, std::move(history)) {
    if (options.keep_history)
      world.recorder().begin_history(options.history_bytes_max, options.record);
    if (options.keep_impacts) world.keep_impacts();
  }

  std::optional<SceneError> run_until(Tick end) {
    if (engine) return engine->run_until(end);
    if (end < now) return {};
    // While nothing differs from the history, only sampling events must be simulated.
    std::optional<Takeover> from;
    if (replaying.active() && options.sample_every == 0 && replaying.quiet_until() > now) {
      skipped = true;
      now = replaying.skip_quiet(end);
      if (now == end) return {};
    }
    if (skipped) from = Takeover{.now = now, .counts = {}, .failure = {}};
    engine = engine_of(world, replaying, options, from);
    return engine->run_until(end);
  }

  SimulationOptions options;
  World world;
  Replaying replaying;
  std::unique_ptr<AnyEngine> engine{};  ///< created when needed
  bool skipped = false;
  bool failed = false;
  Tick now{};  ///< used without an engine
};

Simulation::Simulation(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Simulation::Simulation(Simulation&&) noexcept = default;
Simulation& Simulation::operator=(Simulation&&) noexcept = default;
Simulation::~Simulation() = default;

base::Result<Simulation, SceneError> Simulation::start(const Scene& scene,
                                                       const SimulationOptions& options,
                                                       std::shared_ptr<const History> history) {
  if (auto error = error_of(scene)) return *std::move(error);
  Simulation simulation(std::make_unique<Impl>(scene, options, std::move(history)));
  if (auto error = simulation.impl_->world.lay_down()) return *std::move(error);
  if (auto error = simulation.run_until(Tick{})) return *std::move(error);
  return simulation;
}

std::optional<SceneError> Simulation::run_until(Tick end) {
  auto error = impl_->run_until(end);
  impl_->failed = error.has_value();
  return error;
}

void Simulation::go_on_with(const SimulationOptions& options) {
  impl_->options = options;
  if (impl_->engine)
    impl_->engine = engine_of(impl_->world, impl_->replaying, options, impl_->engine->state());
}

std::span<const SurfaceTouch> Simulation::surface_touches() const {
  return impl_->world.surface_touches();
}

std::span<const Impact> Simulation::impacts() const {
  return impl_->world.impacts();
}

Tick Simulation::now() const {
  return impl_->engine ? impl_->engine->now() : impl_->now;
}
bool Simulation::started(BodyId body) const {
  return impl_->world.bodies().started(body);
}
Pose Simulation::pose(BodyId body, Tick tick) const {
  return impl_->world.bodies().pose_at(body, tick);
}
Twist Simulation::twist(BodyId body, Tick tick) const {
  return impl_->world.bodies().twist_at(body, tick);
}
MotionMode Simulation::mode(BodyId body) const {
  return impl_->world.bodies().mode(body);
}
double Simulation::kinetic_energy_j() const {
  return impl_->world.bodies().kinetic_energy_j(now());
}
const Counts& Simulation::counts() const {
  static constexpr Counts k_none{};
  return impl_->engine ? impl_->engine->counts() : k_none;
}
const Recording& Simulation::recording() const {
  Recording& recording = impl_->world.recorder().recording();
  recording.end_at(now());
  return recording;
}
std::shared_ptr<const History> Simulation::history() const {
  return impl_->failed ? nullptr : impl_->world.history(now());
}

}  // namespace sleight::physics
