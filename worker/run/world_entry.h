// Makes a catalogue entry from a world's class, its request_binding() and its make_state_reader().
#pragma once

#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "worker/run/catalogue.h"
#include "worker/run/chain_worker.h"
#include "worker/sampling/target.h"

namespace sleight::run {

/// Returns the options for a request's worker.
ChainWorkerOptions worker_options(const request::DirectionRequest& request,
                                  const WorkerResources& resources);

template <sampling::ScalesProposals T>
std::vector<bool> kinds_with_scale_of(const T& world) {
  std::vector<bool> kinds;
  for (std::uint32_t kind = 0; kind < world.proposal_kinds(); ++kind)
    kinds.push_back(world.has_scale(kind));
  return kinds;
}

template <class World, class Parameters, request::WorldBinding (*k_binding)(),
          std::unique_ptr<archive::StateReader> (*k_reader)(const Parameters&)>
class EntryOf final : public WorldEntry {
 public:
  request::WorldBinding binding() const override { return k_binding(); }
  std::unique_ptr<plan::UnitWorker> make_worker(const request::DirectionRequest& request,
                                                const WorkerResources& resources) const override {
    return std::make_unique<ChainWorker<World>>(world_of(request),
                                                worker_options(request, resources));
  }
  std::unique_ptr<archive::StateReader> make_reader(
      const request::DirectionRequest& request) const override {
    return k_reader(request::parameters_of<Parameters>(request));
  }
  std::optional<SimulationEnd> simulate(const request::DirectionRequest& request,
                                        base::BytesView state) const override {
    const World world = world_of(request);
    auto decoded = world.decode(state);
    if (!decoded) return std::nullopt;
    const auto sample = sampling::evaluate(world, std::move(*decoded));
    return SimulationEnd{.failure = sampling::report_of(world, sample.outcome).failure,
                         .log_prior = sample.log_prior,
                         .log_constraint = sample.log_constraint};
  }
  std::vector<bool> kinds_with_scale(const request::DirectionRequest& request) const override {
    return kinds_with_scale_of(world_of(request));
  }
  std::vector<sampling::BurnInValue> burn_in_values(
      const request::DirectionRequest& request) const override {
    if constexpr (SearchedWorld<World>) return world_of(request).burn_in_values();
    return {};
  }
  std::string past_effort(const request::DirectionRequest& request) const override {
    const World world = world_of(request);
    if constexpr (requires { world.past_effort(); }) return world.past_effort();
    return {};
  }
  sampling::SearchTexts search_texts(const request::DirectionRequest& request) const override {
    sampling::SearchTexts texts;
    if constexpr (SearchedWorld<World>) {
      const World world = world_of(request);
      for (std::uint32_t stage = 0; stage < world.stages(); ++stage)
        texts.stages.push_back(world.stage_name(stage));
      if constexpr (requires { world.miss_kinds(); }) texts.misses = world.miss_kinds();
      texts.advice = "To print the full constraint, with time limits, run `sleight check`.";
      if constexpr (requires { world.search_advice(); }) texts.advice = world.search_advice();
    }
    return texts;
  }

 private:
  static World world_of(const request::DirectionRequest& request) {
    return World(request::parameters_of<Parameters>(request));
  }
};

}  // namespace sleight::run
