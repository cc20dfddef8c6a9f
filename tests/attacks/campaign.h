// An attack as a whole: episodes of all kinds by several threads, peers that stay meanwhile, and
// honest clients who must be answered throughout.
//
// Episode n is a function of (seed, n): its kind, and all that it sends. Only the server's answers,
// and which episodes run at once, are not. So a failure names its episode, and that alone runs
// again by --episode.
//
// Thread safety: run_campaign starts its own threads and ends them.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "tests/attacks/acts.h"

namespace sleight::attack {

/// An honest client is answered within this.
inline constexpr double k_honest_s_max = 5;

struct Campaign {
  std::uint64_t count = 0;  ///< of attacks
  std::uint64_t seed = 1;
  int threads = 3;
  std::optional<std::uint64_t> episode{};  ///< this one alone
  std::string certificate{};               ///< PEM
};

struct Progress {
  std::uint64_t attacks = 0;
  double seconds = 0;
};

struct Count {
  std::string name{};
  std::uint64_t attacks = 0;
  std::uint64_t reached = 0;
  std::uint64_t turned_away = 0;
};

struct Outcome {
  std::vector<Count> counts{};
  std::uint64_t attacks = 0;
  double seconds = 0;
  std::uint64_t honest_calls = 0;
  double longest_honest_s = 0;
  /// What went wrong, with the episodes that were under way; none: nothing.
  std::optional<std::string> trouble{};
};

/// `tell` is called once a second at first, then every ten seconds.
Outcome run_campaign(const Target& target, const Campaign& campaign,
                     const std::function<void(const Progress&)>& tell);

}  // namespace sleight::attack
