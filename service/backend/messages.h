// The interface of backend.h as JSON, as the service asks engines that are programs and reads their
// answers: docs/BACKENDS.md states it.
//
//   PROGRAM VERB    reads one object, {"version": 1, ...}, prints one, and ends with
//                   0 done, 75 the system doesn't answer, anything else: refused; stderr says why
//
// Whoever reads passes over keys that it does not know, and takes absent ones for their defaults.
//
// Thread safety: pure functions.
#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <string_view>

#include "service/backend/backend.h"

namespace sleight::backend {

inline constexpr int k_message_version = 1;
/// EX_TEMPFAIL of sysexits.h.
inline constexpr int k_exit_away = 75;
/// No message is longer.
inline constexpr std::size_t k_message_bytes_max = std::size_t{64} << 20U;
inline constexpr std::size_t k_log_bytes_most = 64U << 10U;

/// One question, of whichever verb: what a verb does not need is not written.
struct Question {
  Order order{};  ///< of launch; of state, signal and log its name; of list its name's daemon
  keeper::Stop how = keeper::Stop::in_order;  ///< of signal
  std::size_t bytes_max = k_log_bytes_most;   ///< of log
};

std::string text_of_question(std::string_view verb, const Question& question);

// Answers. Each throws base::Error(usage) naming the key that is wrong.
Seen seen_of(std::string_view text);  ///< of launch and state
bool signalled_of(std::string_view text);
std::map<AttemptName, Seen> list_of(const std::string& daemon, std::string_view text);
std::string log_of(std::string_view text, std::size_t bytes_max);

}  // namespace sleight::backend
