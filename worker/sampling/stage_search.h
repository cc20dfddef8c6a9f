// Search: builds a solution stage by stage, for a world that acts in stages.
//
//   Start from a ground drawn from the prior.
//   Until all stages are accepted:
//     Try the next stage, and accept a try that is promising.
//     After too many tries at one stage, take the last stage back.
//     After too many tries in total, give up.
//
// A find has only values that the prior can produce, but finds don't occur in the proportions of
// p_w p_c. Chains may start from finds, but no average, weight or odds may be computed from finds.
//
// A builder is a world together with its guide. Thread safety: as the builder's.
#pragma once

#include <cmath>
#include <compare>
#include <concepts>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/plan/failure.h"
#include "common/random/stream.h"

namespace sleight::sampling {

/// How far a try was from being accepted. The lower of two misses is nearer: a world lists its
/// kinds from near to far, and amounts of one kind compare.
struct Miss {
  std::uint32_t kind = 0;  ///< Index in the world's miss kinds.
  double amount = 0;       ///< In the kind's unit, at least 0.
  friend auto operator<=>(const Miss&, const Miss&) = default;
};

/// For display, such as {"'third note'", "ms"}.
struct MissKind {
  std::string name;
  std::string unit;
};

struct SearchEffort {
  std::uint64_t tries = 0;
  std::uint64_t simulations = 0;  ///< Simulations of prefixes.
  std::uint64_t guesses = 0;      ///< Cheap simulations before a full one.
  std::uint64_t steps_back = 0;
  std::uint32_t furthest = 0;     ///< Maximum number of accepted stages.
  std::optional<Miss> nearest{};  ///< Nearest miss of stage `furthest`.
  std::uint64_t overlapping_starts = 0;
  std::vector<plan::FailurePointer> failures{};

  /// A builder reports that a try of the stage missed. An infinite or NaN amount is ignored.
  void misses(std::uint32_t stage, std::uint32_t kind, double amount) {
    const Miss miss{.kind = kind, .amount = amount};
    if (stage == furthest && std::isfinite(amount) && (!nearest || miss < *nearest)) nearest = miss;
  }
  void accepts(std::uint32_t stage) {
    if (stage < furthest) return;
    furthest = stage + 1;
    nearest.reset();
  }
};

struct SearchLimits {
  std::uint32_t tries_of_stage = 200;  ///< Then the previous stage is taken back.
  std::uint32_t turns_per_stage = 40;  ///< The limit of tries and steps back is this * stages.
};

template <class B>
concept StageBuilder = std::copyable<typename B::Prefix> &&
    requires(const B& builder, const typename B::Prefix& prefix, std::uint32_t stage,
             SearchEffort& effort, random::Stream& stream) {
  { builder.stages() } -> std::same_as<std::uint32_t>;
  { builder.limits() } -> std::same_as<SearchLimits>;
  /// Returns a prefix without stages. The prefix's ground is drawn from the prior.
  { builder.start(stream) } -> std::same_as<typename B::Prefix>;
  /// Tries to extend a prefix of `stage` stages by the next stage. If the try isn't promising, the
  /// result is empty.
  {
    builder.attempt(prefix, stage, effort, stream)
    } -> std::same_as<std::optional<typename B::Prefix>>;
  /// REQUIRES: the prefix has all stages.
  { builder.is_solution(prefix) } -> std::same_as<bool>;
};

/// All random numbers come from the stream. Empty if the search gave up.
template <StageBuilder B>
std::optional<typename B::Prefix> search(const B& builder, const SearchLimits& limits,
                                         random::Stream& stream, SearchEffort& effort) {
  const std::uint32_t stages = builder.stages();
  const std::uint64_t turns_max = std::uint64_t{limits.turns_per_stage} * stages;
  std::vector<typename B::Prefix> prefixes{builder.start(stream)};
  std::uint32_t tries_here = 0;
  for (std::uint64_t turn = 0;; ++turn) {
    const auto stage = static_cast<std::uint32_t>(prefixes.size() - 1);
    if (stage == stages && builder.is_solution(prefixes.back())) return std::move(prefixes.back());
    if (turn == turns_max) return std::nullopt;

    // Take a stage back after too many tries.
    if (stage == stages || tries_here == limits.tries_of_stage) {
      tries_here = 0;
      if (stage == 0) return std::nullopt;
      prefixes.pop_back();
      ++effort.steps_back;
      continue;
    }

    // Try the next stage.
    ++tries_here;
    ++effort.tries;
    auto longer = builder.attempt(prefixes.back(), stage, effort, stream);
    if (!longer) continue;
    prefixes.push_back(*std::move(longer));
    effort.accepts(stage);
    tries_here = 0;
  }
}

}  // namespace sleight::sampling
