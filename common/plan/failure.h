// Simulations that could not be completed.
//
// A failure is a fault of the simulator or of the world's physics scene, not a property of the
// state. So a failed state is never a sample. A chain rejects a candidate whose simulation failed,
// and a failed draw from the prior is repeated; docs/SAMPLING.md describes the effect on the
// distribution. Bodies that overlap at the start are no failure: such a state has a known p_c of 0.
// Thread safety: values.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <numeric>
#include <optional>
#include <string>
#include <string_view>

#include "common/base/bytes.h"

namespace sleight::plan {

enum class FailureKind : std::uint8_t {
  search_gave_up,       ///< A search for a collision examined too many ticks.
  too_many_collisions,  ///< Too many collisions of one body, at one tick or in a millisecond.
  impact_unresolved,    ///< No impulse was found.
  spins_too_long,       ///< A body without contacts turned too fast for its fixed steps.
  work_limit,           ///< Far more events than simulations of this world have.
  scene_refused,        ///< The simulator refused the world's physics scene.
};
inline constexpr std::size_t k_failure_kinds = 6;

/// The kinds' names, as archives, files and messages contain them.
inline constexpr std::array<std::string_view, k_failure_kinds> k_failure_names = {
    "search_gave_up", "too_many_collisions", "impact_unresolved",
    "spins_too_long", "work_limit",          "scene_refused"};

inline std::string_view name_of(FailureKind kind) {
  return k_failure_names.at(static_cast<std::size_t>(kind));
}

/// Returns the kind with that name; empty if there is none.
inline std::optional<FailureKind> failure_kind_of(std::string_view name) {
  for (std::size_t kind = 0; kind < k_failure_kinds; ++kind) {
    if (k_failure_names[kind] == name) return static_cast<FailureKind>(kind);
  }
  return std::nullopt;
}

/// The reason and the state of a failed simulation. Simulating the state again fails in the same
/// way.
struct SimulationFailure {
  FailureKind kind{};
  std::string message;  ///< Describes the fault, the body and the time.
  base::Bytes state;    ///< The state in the world's own encoding.
  friend bool operator==(const SimulationFailure&, const SimulationFailure&) = default;
};

/// Shared, because outcomes are copied. Null if the simulation was completed.
using FailurePointer = std::shared_ptr<const SimulationFailure>;

/// Failures by kind.
struct FailureCounts {
  std::array<std::uint64_t, k_failure_kinds> by_kind{};

  std::uint64_t total() const {
    return std::accumulate(by_kind.begin(), by_kind.end(), std::uint64_t{0});
  }
  void add(FailureKind kind) { ++by_kind.at(static_cast<std::size_t>(kind)); }
  void add(const FailureCounts& other) {
    for (std::size_t kind = 0; kind < k_failure_kinds; ++kind)
      by_kind[kind] += other.by_kind[kind];
  }
  friend bool operator==(const FailureCounts&, const FailureCounts&) = default;
};

/// Returns text such as "search_gave_up 2, work_limit 1". Empty without failures.
std::string to_string(const FailureCounts& counts);

}  // namespace sleight::plan
