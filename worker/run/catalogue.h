// Lists this program's worlds. Each entry has its world's request keys, worker, and reader of
// states.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/archive/world_layout.h"
#include "common/base/bytes.h"
#include "common/plan/failure.h"
#include "common/plan/plan.h"
#include "common/plan/unit.h"
#include "common/request/direction_request.h"
#include "worker/run/sample_cache.h"
#include "worker/sampling/burn_in_judge.h"
#include "worker/sampling/search_lanes.h"

namespace sleight::run {

/// A worker's resources on this machine. Results don't depend on them.
struct WorkerResources {
  std::size_t cache_bytes_max = k_cache_bytes_max;  ///< Memory for held samples.
};

struct SimulationEnd {
  plan::FailurePointer failure{};  ///< Null if the simulation was completed.
  double log_prior = 0;
  double log_constraint = 0;  ///< Valid only if the simulation was completed.
};

/// One world. Thread-safe. REQUIRES: this world's binding has read each request that is passed to
/// the entry.
class WorldEntry {
 public:
  virtual ~WorldEntry() = default;
  virtual request::WorldBinding binding() const = 0;
  virtual std::unique_ptr<plan::UnitWorker> make_worker(
      const request::DirectionRequest& request, const WorkerResources& resources = {}) const = 0;
  virtual std::unique_ptr<archive::StateReader> make_reader(
      const request::DirectionRequest& request) const = 0;
  /// Simulates a state in the same way as a run's worker. Empty if the bytes aren't a state of this
  /// world.
  virtual std::optional<SimulationEnd> simulate(const request::DirectionRequest& request,
                                                base::BytesView state) const = 0;
  /// Returns, for each kind of proposal, whether it has a tunable scale.
  virtual std::vector<bool> kinds_with_scale(const request::DirectionRequest& request) const = 0;
  /// The values that judge the burn-in of chains from a search. Empty if the world has no search.
  virtual std::vector<sampling::BurnInValue> burn_in_values(
      const request::DirectionRequest& request) const = 0;
  /// A sentence for display: how long similar requests took until solutions had the model's
  /// proportions. Empty if unknown.
  virtual std::string past_effort(const request::DirectionRequest& request) const = 0;
  /// Texts for messages about a search. Empty if the world has no search.
  virtual sampling::SearchTexts search_texts(const request::DirectionRequest& request) const = 0;
};

class Catalogue {
 public:
  Catalogue();
  explicit Catalogue(std::vector<std::unique_ptr<WorldEntry>> worlds);
  /// Bindings of all worlds, which read_request and help need.
  std::vector<request::WorldBinding> bindings() const;
  /// REQUIRES: these bindings have read the request.
  const WorldEntry& world_of(const request::DirectionRequest& request) const;

 private:
  std::vector<std::unique_ptr<WorldEntry>> worlds_;
};

/// Returns the plan of a request's sampling method. If `cut` is set, the run ends at the cut.
std::unique_ptr<plan::Plan> make_plan(const request::DirectionRequest& request,
                                      const WorldEntry& world,
                                      const std::optional<request::Cut>& cut = {});

}  // namespace sleight::run
