// Cap'n Proto messages as frames: plain calls, and messages that no client would send.
//
// A connection's question 0 requests the bootstrap object. Question 1 opens a session or logs in,
// and its result is a promise of the service. Attacks use question numbers from 2 on.
//
// Thread safety: functions change only their Dice.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "tests/attacks/odd_values.h"
#include "tests/attacks/parameters.h"

namespace sleight::attack {

inline constexpr std::uint32_t k_first_question = 2;

struct Asked {
  std::string frame{};
  std::uint32_t question = 0;
  /// Whether the call may take longer than k_patience_ms: watch, or fetch of a derived file.
  bool may_wait = false;
};

/// Questions 0 and 1.
std::string opening();
std::string login(const std::string& token);

/// A call of any method with valid parameters. The server must answer the call.
Asked valid_call(Dice& dice, const Bounds& bounds, std::uint32_t question);
/// Releases the question's results.
std::string finish(std::uint32_t question);

/// Messages about questions, capabilities and promises that don't exist.
std::string odd_protocol(Dice& dice);
/// A call on the promised result of another question, or on an existing or missing capability.
std::string pipelined_call(Dice& dice, std::uint32_t question);
/// A call that passes the client's capabilities, and later messages about the capabilities.
std::vector<std::string> calls_with_capabilities(Dice& dice, std::uint32_t question);
/// A call with random pointers. Pointers may point outside the message or to themselves, or nest
/// deeply.
std::string odd_pointers(Dice& dice, std::uint32_t question);
/// Any of the above messages with some bytes changed.
std::string mutated(Dice& dice, const Bounds& bounds, std::uint32_t question);
/// A frame whose header is wrong.
std::string broken_frame(Dice& dice);

}  // namespace sleight::attack
