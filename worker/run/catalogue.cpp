#include "worker/run/catalogue.h"

#include <string>

#include "common/base/check.h"
#include "worker/run/chain_worker.h"
#include "worker/sampling/independent_chains.h"
#include "worker/worlds/ball_2d/ball_2d.h"
#include "worker/worlds/ball_2d/request.h"
#include "worker/worlds/spelling/reader.h"
#include "worker/worlds/spelling/request.h"
#include "worker/worlds/spelling/spelling.h"

namespace sleight::run {
namespace {

ChainWorkerOptions worker_options(const request::DirectionRequest& request) {
  return {.seed = request.sampler.seed,
          .iterations_per_scan = request.sampler.iterations_per_scan,
          .thin = request.output.thin};
}

class Ball2dEntry final : public WorldEntry {
 public:
  request::WorldBinding binding() override { return worlds::ball_2d::request_binding(parameters_); }
  std::unique_ptr<plan::UnitWorker> make_worker(
      const request::DirectionRequest& request) const override {
    return std::make_unique<ChainWorker<worlds::ball_2d::Ball2d>>(
        worlds::ball_2d::Ball2d(parameters_), worker_options(request));
  }
  std::unique_ptr<archive::StateReader> make_reader() const override {
    return worlds::ball_2d::make_state_reader(parameters_);
  }

 private:
  worlds::ball_2d::Parameters parameters_;
};

class SpellingEntry final : public WorldEntry {
 public:
  request::WorldBinding binding() override {
    return worlds::spelling::request_binding(parameters_);
  }
  std::unique_ptr<plan::UnitWorker> make_worker(
      const request::DirectionRequest& request) const override {
    return std::make_unique<ChainWorker<worlds::spelling::Spelling>>(
        worlds::spelling::Spelling(parameters_), worker_options(request));
  }
  std::unique_ptr<archive::StateReader> make_reader() const override {
    return worlds::spelling::make_state_reader(parameters_);
  }

 private:
  worlds::spelling::Parameters parameters_;
};

}  // namespace

Catalogue::Catalogue() {
  worlds_.push_back({"ball_2d", std::make_unique<Ball2dEntry>()});
  worlds_.push_back({"spelling", std::make_unique<SpellingEntry>()});
}

std::vector<request::WorldBinding> Catalogue::bindings() {
  std::vector<request::WorldBinding> all;
  for (const Named& world : worlds_)
    all.push_back(world.entry->binding());
  return all;
}

const WorldEntry& Catalogue::world(std::string_view name) const {
  for (const Named& world : worlds_) {
    if (world.name == name) return *world.entry;
  }
  base::check_failed("a world of this name", name);
}

std::unique_ptr<plan::Plan> make_plan(const request::DirectionRequest& request) {
  CHECK(request.sampler.method == request::Method::metropolis_hastings);
  return std::make_unique<sampling::IndependentChains>(sampling::IndependentChainsOptions{
      .chains = request.sampler.chains,
      .round_scans = request.sampler.round_scans,
      .stop = {.scans = request.stop.scans,
               .rounds = request.stop.rounds,
               .independent_solutions = request.stop.independent_solutions}});
}

}  // namespace sleight::run
