// Cap'n Proto messages as frames, from plain calls to messages that no client would send.
//
// A connection's question 0 requests the bootstrap object, and question 1 opens a session or logs
// in; its result promises the service. Attacks use numbers from 2 on.
//
// Thread safety: pure functions of their Dice.
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
  /// A watch, or a fetch of a derived file, whose answer may take longer than k_patience_ms.
  bool may_wait = false;
};

/// Questions 0 and 1.
std::string opening();
std::string login(const std::string& token);

/// A valid call of any method with any parameters, which the server must answer.
Asked valid_call(Dice& dice, const Bounds& bounds, std::uint32_t question);
/// Releases the question's results.
std::string finish(std::uint32_t question);

/// Messages about questions, capabilities and promises that don't exist.
std::string odd_protocol(Dice& dice);
/// A call on the promised result of another question, or on capabilities that exist or don't.
std::string pipelined_call(Dice& dice, std::uint32_t question);
/// A call with the client's capabilities, and the client's later messages about them.
std::vector<std::string> calls_with_capabilities(Dice& dice, std::uint32_t question);
/// A call with invalid pointers: beyond the message, to themselves, or deeply nested.
std::string odd_pointers(Dice& dice, std::uint32_t question);
/// A message of any of the kinds above with some bytes changed.
std::string mutated(Dice& dice, const Bounds& bounds, std::uint32_t question);
/// A frame whose header is wrong.
std::string broken_frame(Dice& dice);

}  // namespace sleight::attack
