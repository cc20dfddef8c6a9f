// Identifiers as distinct types: a chain is not a replica, a scan is not an iteration.
#pragma once

#include <fmt/format.h>

#include <compare>
#include <concepts>
#include <cstdint>

namespace sleight::base {

template <class Tag, class Representation>
struct Id {
  using representation = Representation;
  Representation value{};
  friend constexpr auto operator<=>(Id, Id) = default;
};

/// A distinct type for an index into arrays. An Index converts to its number implicitly. Numbers
/// and indices of other kinds convert to an Index only explicitly: Index{n}. Indices of different
/// kinds can't be compared.
template <class Tag>
struct Index {
  std::uint32_t value{};
  constexpr operator std::uint32_t() const { return value; }  // NOLINT: that is its purpose
  constexpr Index& operator++() {
    ++value;
    return *this;
  }
  friend constexpr auto operator<=>(Index, Index) = default;
  template <class Other>
  requires(!std::same_as<Tag, Other>) friend bool operator==(Index, Index<Other>) = delete;
  template <class Other>
  requires(!std::same_as<Tag, Other>) friend std::strong_ordering operator<=>(Index, Index<Other>) =
      delete;
};

/// Identifies a chain. A ladder of tempered replicas also counts as one chain. Chains are
/// independent. The archive's `chain`.
using ChainId = Id<struct ChainTag, std::uint32_t>;
/// A replica of a ladder. A plain chain has only replica 0.
using ReplicaId = Id<struct ReplicaTag, std::uint32_t>;
/// Scan 0 is the start (a draw from the prior); each later scan is `iterations_per_scan` proposals.
using ScanIndex = Id<struct ScanTag, std::uint64_t>;

}  // namespace sleight::base

template <class Tag, class Representation>
struct fmt::formatter<sleight::base::Id<Tag, Representation>> : fmt::formatter<Representation> {
  template <class Context>
  auto format(sleight::base::Id<Tag, Representation> id, Context& context) const {
    return fmt::formatter<Representation>::format(id.value, context);
  }
};

template <class Tag>
struct fmt::formatter<sleight::base::Index<Tag>> : fmt::formatter<std::uint32_t> {
  template <class Context>
  auto format(sleight::base::Index<Tag> index, Context& context) const {
    return fmt::formatter<std::uint32_t>::format(index.value, context);
  }
};
