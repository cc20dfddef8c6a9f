// Identifiers as distinct types: a chain is not a replica, a scan is not an iteration.
#pragma once

#include <fmt/format.h>

#include <compare>
#include <cstdint>

namespace sleight::base {

template <class Tag, class Representation>
struct Id {
  using representation = Representation;
  Representation value{};
  friend constexpr auto operator<=>(Id, Id) = default;
};

/// An independent chain, or an independent ladder of tempered replicas: the archive's `chain`.
using ChainId = Id<struct ChainTag, std::uint32_t>;
/// One of a ladder's replicas; a plain chain has replica 0 alone.
using ReplicaId = Id<struct ReplicaTag, std::uint32_t>;
/// Scan 0 is the start (a draw from the prior); every later one is `iterations_per_scan` proposals.
using ScanIndex = Id<struct ScanTag, std::uint64_t>;

}  // namespace sleight::base

template <class Tag, class Representation>
struct fmt::formatter<sleight::base::Id<Tag, Representation>> : fmt::formatter<Representation> {
  template <class Context>
  auto format(sleight::base::Id<Tag, Representation> id, Context& context) const {
    return fmt::formatter<Representation>::format(id.value, context);
  }
};
