// A whole attack: threads run episodes, held peers stay connected, and the service must answer
// honest clients.
//
// Episode n's kind and messages depend only on (seed, n). Only the server's answers and the
// concurrent episodes vary. The option --episode repeats the episode that a failure names.
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

/// Maximum time for answering an honest client.
inline constexpr double k_honest_s_max = 5;

struct Campaign {
  std::uint64_t count = 0;  ///< number of attacks
  std::uint64_t seed = 1;
  int threads = 3;
  std::optional<std::uint64_t> episode{};  ///< run only this episode
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
  /// What went wrong, and which episodes were in progress. None: nothing.
  std::optional<std::string> trouble{};
};

/// Calls tell() every second at first, then every ten seconds.
Outcome run_campaign(const Target& target, const Campaign& campaign,
                     const std::function<void(const Progress&)>& tell);

}  // namespace sleight::attack
