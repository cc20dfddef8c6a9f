#include "worker/physics/simulator/simulation.h"

#include <utility>

#include "worker/physics/broad_phase/hierarchical_grid.h"
#include "worker/physics/broad_phase/sweep_and_prune.h"
#include "worker/physics/event/calendar_queue.h"
#include "worker/physics/event/heap_queue.h"
#include "worker/physics/event/tournament_queue.h"
#include "worker/physics/simulator/engine.h"

namespace sleight::physics {
namespace {

/// An engine of any kind.
class AnyEngine {
 public:
  virtual ~AnyEngine() = default;
  virtual std::optional<SceneError> run_until(Tick end) = 0;
  virtual Tick now() const = 0;
  virtual const Counts& counts() const = 0;
  virtual Takeover state() const = 0;
};

template <class Boxes, class Queue>
class EngineOf final : public AnyEngine {
 public:
  EngineOf(World& world, const EngineOptions& options, const std::optional<Takeover>& from)
      : engine_(world, options, from) {}
  std::optional<SceneError> run_until(Tick end) override { return engine_.run_until(end); }
  Tick now() const override { return engine_.now(); }
  const Counts& counts() const override { return engine_.counts(); }
  Takeover state() const override { return engine_.state(); }

 private:
  Engine<Boxes, Queue> engine_;
};

template <class Boxes>
std::unique_ptr<AnyEngine> engine_with(World& world, QueueKind queue, const EngineOptions& options,
                                       const std::optional<Takeover>& from) {
  switch (queue) {
    case QueueKind::tournament:
      return std::make_unique<EngineOf<Boxes, TournamentQueue>>(world, options, from);
    case QueueKind::heap:
      return std::make_unique<EngineOf<Boxes, HeapQueue>>(world, options, from);
    case QueueKind::calendar:
      break;
  }
  return std::make_unique<EngineOf<Boxes, CalendarQueue>>(world, options, from);
}

std::unique_ptr<AnyEngine> engine_of(World& world, const SimulationOptions& options,
                                     const std::optional<Takeover>& from) {
  const EngineOptions chosen{.algorithm = options.algorithm,
                             .sample_every = options.sample_every,
                             .on_sample = options.on_sample};
  return options.broad_phase == BroadPhaseKind::sweep_and_prune
             ? engine_with<SweepAndPrune>(world, options.queue, chosen, from)
             : engine_with<HierarchicalGrid>(world, options.queue, chosen, from);
}

}  // namespace

class Simulation::Impl {
 public:
  Impl(const Scene& scene, const SimulationOptions& options)
      : world(scene, options.record, options.segments_reserved),
        engine(engine_of(world, options, std::nullopt)) {}

  World world;
  std::unique_ptr<AnyEngine> engine;
};

Simulation::Simulation(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Simulation::Simulation(Simulation&&) noexcept = default;
Simulation& Simulation::operator=(Simulation&&) noexcept = default;
Simulation::~Simulation() = default;

base::Result<Simulation, SceneError> Simulation::start(const Scene& scene,
                                                       const SimulationOptions& options) {
  if (auto error = error_of(scene)) return *std::move(error);
  Simulation simulation(std::make_unique<Impl>(scene, options));
  if (auto error = simulation.run_until(Tick{})) return *std::move(error);
  return simulation;
}

std::optional<SceneError> Simulation::run_until(Tick end) {
  auto error = impl_->engine->run_until(end);
  impl_->world.recording().end_at(impl_->engine->now());
  return error;
}

void Simulation::go_on_with(const SimulationOptions& options) {
  impl_->engine = engine_of(impl_->world, options, impl_->engine->state());
}

Tick Simulation::now() const {
  return impl_->engine->now();
}
bool Simulation::started(BodyId body) const {
  return impl_->world.started(body.value);
}
Pose Simulation::pose(BodyId body, Tick tick) const {
  return impl_->world.pose_at(body.value, tick);
}
Twist Simulation::twist(BodyId body, Tick tick) const {
  return impl_->world.twist_at(body.value, tick);
}
MotionMode Simulation::mode(BodyId body) const {
  return impl_->world.segment(body.value).mode;
}
double Simulation::kinetic_energy_j() const {
  return impl_->world.kinetic_energy_j(now());
}
const Counts& Simulation::counts() const {
  return impl_->engine->counts();
}
const Recording& Simulation::recording() const {
  return impl_->world.recording();
}

}  // namespace sleight::physics
