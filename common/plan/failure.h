// Simulations that could not be carried out.
//
// A failure is a fault of the simulator, or of the scene that a world made, and says nothing about
// the state: it is never a sample. A chain refuses a candidate whose simulation failed, and a draw
// from the prior is drawn again; docs/SAMPLING.md says what that does to the distribution. Starts
// that overlap are no failures: such a state has p_c = 0, which is known.
//
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
  search_gave_up,       ///< a search for a collision examined too many ticks
  too_many_collisions,  ///< of one body, at one tick or in a millisecond
  impact_unresolved,    ///< no impulse was found
  spins_too_long,       ///< a body that touches nothing turned too fast for its fixed steps
  work_limit,           ///< far more events than simulations of this world have
  scene_refused,        ///< the simulator refused the world's scene
};
inline constexpr std::size_t k_failure_kinds = 6;

/// The kinds' names, as archives, files and messages have them.
inline constexpr std::array<std::string_view, k_failure_kinds> k_failure_names = {
    "search_gave_up", "too_many_collisions", "impact_unresolved",
    "spins_too_long", "work_limit",          "scene_refused"};

inline std::string_view name_of(FailureKind kind) {
  return k_failure_names.at(static_cast<std::size_t>(kind));
}

/// The kind of that name; nothing if there is none.
inline std::optional<FailureKind> failure_kind_of(std::string_view name) {
  for (std::size_t kind = 0; kind < k_failure_kinds; ++kind) {
    if (k_failure_names[kind] == name) return static_cast<FailureKind>(kind);
  }
  return std::nullopt;
}

/// Why a simulation failed, and of which state: simulating it again fails alike.
struct SimulationFailure {
  FailureKind kind{};
  std::string message;  ///< what, of which body, and when
  base::Bytes state;    ///< in the world's own encoding
  friend bool operator==(const SimulationFailure&, const SimulationFailure&) = default;
};

/// Shared, since outcomes are copied; null if the simulation was carried out.
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

/// "search_gave_up 2, work_limit 1"; empty if there are none.
std::string to_string(const FailureCounts& counts);

}  // namespace sleight::plan
