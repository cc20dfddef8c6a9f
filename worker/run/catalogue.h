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

/// One world; its parameters are those of the request read last through binding().
/// Not thread-safe; what make_worker and make_reader return is.
class WorldEntry {
 public:
  virtual ~WorldEntry() = default;
  virtual request::WorldBinding binding() = 0;
  virtual std::unique_ptr<plan::UnitWorker> make_worker(
      const request::DirectionRequest& request, const WorkerResources& resources = {}) const = 0;
  virtual std::unique_ptr<archive::StateReader> make_reader() const = 0;
  /// What the simulation of a state comes to, as a run's worker makes it; nothing if these bytes
  /// are no state of this world.
  virtual std::optional<SimulationEnd> simulate(base::BytesView state) const = 0;
  /// By kind of proposal: whether it has a size that can be tuned.
  virtual std::vector<bool> kinds_with_scale() const = 0;
  /// What chains that start from a search are judged by; empty of a world that can't be searched.
  virtual std::vector<sampling::BurnInValue> burn_in_values() const = 0;
  /// For people: what solutions in proportion took before; empty where that is not told.
  virtual std::string past_effort() const = 0;
  /// By stage, for people: "ball 3 of 16"; empty of a world that can't be searched.
  virtual std::vector<std::string> stage_names() const = 0;
};

class Catalogue {
 public:
  struct Named {
    std::string name;
    std::unique_ptr<WorldEntry> entry;
  };

  /// All worlds, in alphabetical order.
  Catalogue();
  /// These worlds, for tests.
  explicit Catalogue(std::vector<Named> worlds);
  /// Bindings of all worlds, for read_request and help; they write into this catalogue.
  std::vector<request::WorldBinding> bindings();
  /// REQUIRES: a world of that name.
  const WorldEntry& world(std::string_view name) const;

 private:
  std::vector<Named> worlds_;
};

/// The plan of a request's sampling method; with a cut, of a run that ends there instead of by the
/// request's own rule.
std::unique_ptr<plan::Plan> make_plan(const request::DirectionRequest& request,
                                      const WorldEntry& world,
                                      const std::optional<request::Cut>& cut = {});

}  // namespace sleight::run
