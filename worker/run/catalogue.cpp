#include "worker/run/catalogue.h"

#include <functional>
#include <utility>

#include "common/base/check.h"
#include "worker/run/world_entry.h"
#include "worker/sampling/annealed_importance.h"
#include "worker/sampling/burnt_in_chains.h"
#include "worker/sampling/excursions.h"
#include "worker/sampling/free_islands.h"
#include "worker/sampling/independent_chains.h"
#include "worker/sampling/judged_chains.h"
#include "worker/sampling/ladder.h"
#include "worker/sampling/parallel_tempering.h"
#include "worker/sampling/prior_lanes.h"
#include "worker/sampling/relaxed_finds.h"
#include "worker/sampling/restarted_chains.h"
#include "worker/sampling/search_first.h"
#include "worker/sampling/simulated_tempering.h"
#include "worker/worlds/ball_2d/ball_2d.h"
#include "worker/worlds/ball_2d/request.h"
#include "worker/worlds/dice/request.h"
#include "worker/worlds/dice/throw_stages.h"
#include "worker/worlds/readers/readers.h"
#include "worker/worlds/spelling/pouring_stages.h"
#include "worker/worlds/spelling/request.h"
#include "worker/worlds/user_scene/request.h"
#include "worker/worlds/user_scene/scene_search.h"

namespace sleight::run {
namespace {

/// Number of temperatures if the request doesn't set it.
constexpr std::uint32_t k_first_replicas = 12;
static_assert(k_first_replicas == 12 && sampling::k_first_power == 6,
              "the help text of ladder_power contains these values");
static_assert(request::k_chains_max <= plan::k_first_lane);
/// The excursions of every valid request are within the method's limit.
static_assert(request::k_excursion_iterations_max <= sampling::k_excursion_steps_max);

namespace ball_2d = worlds::ball_2d;
namespace dice = worlds::dice;
namespace spelling = worlds::spelling;
namespace user_scene = worlds::user_scene;
using Ball2dEntry = EntryOf<ball_2d::Ball2d, ball_2d::Parameters, &ball_2d::request_binding,
                            &ball_2d::make_state_reader>;
using DiceEntry =
    EntryOf<dice::StagedDice, dice::Parameters, &dice::request_binding, &dice::make_state_reader>;
using SpellingEntry = EntryOf<spelling::StagedSpelling, spelling::Parameters,
                              &spelling::request_binding, &spelling::make_state_reader>;
using SceneEntry = EntryOf<user_scene::UserScene, user_scene::Parameters,
                           &user_scene::request_binding, &user_scene::make_state_reader>;

}  // namespace

ChainWorkerOptions worker_options(const request::DirectionRequest& request,
                                  const WorkerResources& resources) {
  const request::SamplerParameters& sampler = request.sampler;
  // With these methods, not every scan is a draw, so the scans to archive aren't known in advance.
  const bool scans_are_draws = sampler.method != request::Method::simulated_tempering &&
                               sampler.method != request::Method::annealed_importance;
  const bool is_tempered = sampler.method == request::Method::parallel_tempering;
  // The scans to archive aren't known in advance either if burn-ins are judged during the run.
  const bool starts_by_search = sampler.start == request::Start::search;
  return {.iterations_per_scan = sampler.iterations_per_scan,
          // Each tour has one draw.
          .thin = scans_are_draws && !starts_by_search
                      ? std::uint64_t{request.output.thin} * sampler.tour_scans.value_or(1)
                      : 1,
          .first_draw = request::scans_before_draws(sampler),
          .hot_thin = is_tempered ? k_hot_thin * request.output.thin : 0,
          .particles = request::makes_islands(sampler.method)
                           ? sampler.particles.value_or(request::k_particles)
                           : 0,
          .starts_by_search = starts_by_search,
          .relax_scans = sampler.relax_scans.value_or(0),
          .is_judged = starts_by_search && !is_tempered,
          .cache_bytes_max = resources.cache_bytes_max};
}

Catalogue::Catalogue() {
  worlds_.push_back(std::make_unique<Ball2dEntry>());
  worlds_.push_back(std::make_unique<DiceEntry>());
  worlds_.push_back(std::make_unique<SceneEntry>());
  worlds_.push_back(std::make_unique<SpellingEntry>());
}

Catalogue::Catalogue(std::vector<std::unique_ptr<WorldEntry>> worlds)
    : worlds_(std::move(worlds)) {}

std::vector<request::WorldBinding> Catalogue::bindings() const {
  std::vector<request::WorldBinding> all;
  for (const auto& world : worlds_)
    all.push_back(world->binding());
  return all;
}

const WorldEntry& Catalogue::world_of(const request::DirectionRequest& request) const {
  for (const auto& world : worlds_) {
    if (world->binding().name == request.world) return *world;
  }
  base::check_failed("the catalogue contains the named world", request.world);
}

namespace {

sampling::StopRule stop_of(const request::DirectionRequest& request,
                           const std::optional<request::Cut>& cut) {
  // If a run with islands is cut, it keeps `independent_solutions`: under this rule, not all
  // islands count.
  const bool has_islands = request.sampler.method == request::Method::sequential;
  sampling::StopRule rule{.scans = request.stop.scans,
                          .rounds = request.stop.rounds,
                          .independent_solutions = request.stop.independent_solutions};
  if (!cut) return rule;
  rule.scans = cut->scans;
  rule.rounds.reset();
  if (!has_islands) rule.independent_solutions.reset();
  return rule;
}

sampling::LadderOptions ladder_of(const request::DirectionRequest& request,
                                  const WorldEntry& world) {
  const request::SamplerParameters& sampler = request.sampler;
  return {.seed = sampler.seed,
          .chain = {},
          .first_ladder =
              sampling::first_ladder(sampler.replicas.value_or(k_first_replicas),
                                     sampler.ladder_power.value_or(sampling::k_first_power)),
          .levels_chosen = !sampler.replicas,
          .levels_max = request::k_chosen_replicas_max,
          .ladder_adapts = true,
          .has_scale = world.kinds_with_scale(request),
          .round_scans = sampler.round_scans,
          .anneal_scans = sampler.anneal_scans.value_or(0),
          .starts_by_search = sampler.start == request::Start::search};
}

using GoOn = std::function<std::unique_ptr<sampling::ChainPart>(const sampling::BurnIn&)>;

GoOn go_on_with(const request::SamplerParameters& sampler) {
  switch (sampler.method) {
    case request::Method::simulated_tempering:
      return [](const sampling::BurnIn& burn_in) {
        return std::make_unique<sampling::SimulatedTempering>(burn_in);
      };
    case request::Method::tempered_transitions:
      return [steps = sampler.steps_per_level.value_or(1)](const sampling::BurnIn& burn_in) {
        return std::make_unique<sampling::Excursions>(burn_in, steps);
      };
    case request::Method::annealed_importance:
      return [lanes = sampler.lanes.value_or(request::k_lanes),
              steps = sampler.steps_per_level.value_or(1)](const sampling::BurnIn& burn_in) {
        return std::make_unique<sampling::AnnealedImportance>(burn_in, lanes, steps);
      };
    case request::Method::metropolis_hastings:
    case request::Method::parallel_tempering:
    case request::Method::sequential:
    case request::Method::splitting:
    case request::Method::search:
      break;
  }
  base::check_failed("the method has a burn-in", "");
}

/// Returns the plan of a request's chains. Null if the request is only a search.
std::unique_ptr<plan::Plan> plan_of_chains(const request::DirectionRequest& request,
                                           const WorldEntry& world,
                                           const sampling::StopRule& stop) {
  const request::SamplerParameters& sampler = request.sampler;
  switch (sampler.method) {
    case request::Method::search:
      return nullptr;
    case request::Method::metropolis_hastings:
    case request::Method::sequential:
    case request::Method::splitting: {
      if (sampler.start == request::Start::search) {
        return std::make_unique<sampling::JudgedChains>(
            sampling::JudgedChainsOptions{.seed = sampler.seed,
                                          .chains = sampler.chains,
                                          .round_scans = sampler.round_scans,
                                          .judged = world.burn_in_values(request),
                                          .scans = stop.scans,
                                          .independent_solutions = stop.independent_solutions});
      }
      if (request.stop.odds) {
        return std::make_unique<sampling::FreeIslands>(sampling::FreeIslandsOptions{
            .seed = sampler.seed, .log_error = *request.stop.odds, .islands_max = stop.scans});
      }
      if (sampler.tour_scans) {
        return std::make_unique<sampling::RestartedChains>(
            sampling::RestartedChainsOptions{.seed = sampler.seed,
                                             .chains = sampler.chains,
                                             .tour_scans = *sampler.tour_scans,
                                             .scans = stop.scans,
                                             .independent_solutions = stop.independent_solutions});
      }
      const std::uint64_t anneal_scans = sampler.anneal_scans.value_or(0);
      return std::make_unique<sampling::IndependentChains>(sampling::IndependentChainsOptions{
          .seed = sampler.seed,
          .chains = sampler.chains,
          .round_scans = sampler.round_scans,
          .anneal_scans = anneal_scans,
          .burn_in_scans = request::scans_before_draws(sampler) - anneal_scans,
          .has_islands = sampler.method == request::Method::sequential,
          .stop = stop});
    }
    case request::Method::parallel_tempering:
      return std::make_unique<sampling::ParallelTempering>(sampling::ParallelTemperingOptions{
          .ladders = sampler.chains, .ladder = ladder_of(request, world), .stop = stop});
    case request::Method::simulated_tempering:
    case request::Method::tempered_transitions:
    case request::Method::annealed_importance:
      return std::make_unique<sampling::BurntInChains>(sampling::BurntInOptions{
          .chains = sampler.chains,
          .ladder = ladder_of(request, world),
          .burn_in_rounds = sampler.burn_in_rounds.value_or(request::k_burn_in_rounds),
          .stop = stop,
          .go_on = go_on_with(sampler)});
  }
  base::check_failed("the method is known", "");
}

}  // namespace

std::unique_ptr<plan::Plan> make_plan(const request::DirectionRequest& request,
                                      const WorldEntry& world,
                                      const std::optional<request::Cut>& cut) {
  const request::SamplerParameters& sampler = request.sampler;
  const auto search = [&](std::uint64_t finds) {
    return sampling::SearchLanes(sampler.seed, finds, world.search_texts(request));
  };
  std::unique_ptr<plan::Plan> plan;
  if (sampler.relax_scans) {
    const std::uint64_t takes = cut ? cut->relaxed : *request.stop.takes;
    plan = std::make_unique<sampling::RelaxedFinds>(
        search(takes), sampling::RelaxedOptions{
                           .seed = sampler.seed, .takes = takes, .scans = *sampler.relax_scans});
  } else {
    plan = plan_of_chains(request, world, stop_of(request, cut));
    const std::uint64_t finds = cut ? cut->found : request.stop.found.value_or(0);
    if (!plan || finds > 0)
      plan = std::make_unique<sampling::SearchFirst>(search(finds), std::move(plan));
  }
  return std::make_unique<sampling::WithPriorDraws>(
      std::move(plan), cut ? cut->prior_draws : request.output.prior_draws);
}

}  // namespace sleight::run
