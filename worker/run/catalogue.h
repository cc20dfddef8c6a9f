// The worlds that this program has, each with what a run needs of it: its request keys, a worker
// that computes its units, and a reader of its states.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/archive/world_layout.h"
#include "common/base/bytes.h"
#include "common/plan/failure.h"
#include "common/plan/plan.h"
#include "common/plan/unit.h"
#include "common/request/direction_request.h"
#include "worker/run/sample_cache.h"
#include "worker/sampling/burn_in_judge.h"

namespace sleight::run {

/// What a worker may take up on this machine; changes no result.
struct WorkerResources {
  std::size_t cache_bytes_max = k_cache_bytes_max;  ///< of samples held for their next units
};

/// How a simulation ended.
struct SimulationEnd {
  plan::FailurePointer failure{};  ///< null: it was carried out
  double log_prior = 0;
  double log_constraint = 0;  ///< of one that was carried out
};

/// One world. Thread-safe. REQUIRES of each request: it was read by this world's binding.
class WorldEntry {
 public:
  virtual ~WorldEntry() = default;
  virtual request::WorldBinding binding() const = 0;
  virtual std::unique_ptr<plan::UnitWorker> make_worker(
      const request::DirectionRequest& request, const WorkerResources& resources = {}) const = 0;
  virtual std::unique_ptr<archive::StateReader> make_reader(
      const request::DirectionRequest& request) const = 0;
  /// Simulates a state as a run's worker does; none if the bytes are no state of this world.
  virtual std::optional<SimulationEnd> simulate(const request::DirectionRequest& request,
                                                base::BytesView state) const = 0;
  /// By kind of proposal: whether it has a size that can be tuned.
  virtual std::vector<bool> kinds_with_scale(const request::DirectionRequest& request) const = 0;
  /// The values that judge chains which start from a search; empty if it can't be searched.
  virtual std::vector<sampling::BurnInValue> burn_in_values(
      const request::DirectionRequest& request) const = 0;
  /// For people: what solutions in proportion took before; empty where that is not told.
  virtual std::string past_effort(const request::DirectionRequest& request) const = 0;
  /// By stage, for people: "ball 3 of 16"; empty if it can't be searched.
  virtual std::vector<std::string> stage_names(const request::DirectionRequest& request) const = 0;
};

class Catalogue {
 public:
  /// All worlds, in alphabetical order.
  Catalogue();
  /// These worlds, for tests.
  explicit Catalogue(std::vector<std::unique_ptr<WorldEntry>> worlds);
  /// Bindings of all worlds, for read_request and help.
  std::vector<request::WorldBinding> bindings() const;
  /// REQUIRES: the request was read with these bindings.
  const WorldEntry& world_of(const request::DirectionRequest& request) const;

 private:
  std::vector<std::unique_ptr<WorldEntry>> worlds_;
};

/// The plan of a request's sampling method; with a cut, of a run that ends there instead of by the
/// request's own rule.
std::unique_ptr<plan::Plan> make_plan(const request::DirectionRequest& request,
                                      const WorldEntry& world,
                                      const std::optional<request::Cut>& cut = {});

}  // namespace sleight::run
