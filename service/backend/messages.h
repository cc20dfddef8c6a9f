// The calls of backend.h as JSON, for backends that are programs. docs/BACKENDS.md specifies this
// JSON.
//
// `PROGRAM VERB` reads an object, {"version": 1, ...}, and prints another. Exit code 0 means done;
// 75 means that the system doesn't answer. Any other code means that the request was refused.
// Stderr then has the reason.
//
// Readers ignore unknown keys. If a key is missing, readers use its default.
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
/// Maximum size of a message.
inline constexpr std::size_t k_message_bytes_max = std::size_t{64} << 20U;
inline constexpr std::size_t k_log_bytes_most = 64U << 10U;

/// The input of any verb. Only the fields that the verb needs are written.
struct Question {
  Order order{};  ///< launch: all; state, signal, log: the name; list: the name's daemon
  keeper::Stop how = keeper::Stop::in_order;  ///< for signal
  std::size_t bytes_max = k_log_bytes_most;   ///< for log
};

std::string text_of_question(std::string_view verb, const Question& question);

// Answers. If a key is wrong, each function throws base::Error(usage) with the key's name.
Seen seen_of(std::string_view text);  ///< of launch and state
bool signalled_of(std::string_view text);
std::map<AttemptName, Seen> list_of(const std::string& daemon, std::string_view text);
std::string log_of(std::string_view text, std::size_t bytes_max);

}  // namespace sleight::backend
