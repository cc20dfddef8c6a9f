// Messages of Cap'n Proto as frames, from plain calls to what no client would ever say.
//
// A connection's questions: 0 asks for the entrance, 1 opens or logs in; its results promise the
// service. Attacks use numbers from 2 on.
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
  /// A watch, or a fetch of what is made first: its answer may take longer than our patience.
  bool may_wait = false;
};

/// Questions 0 and 1.
std::string opening();
std::string login(const std::string& token);

/// A call that the server can read, of any method with any parameters. It owes an answer.
Asked valid_call(Dice& dice, const Bounds& bounds, std::uint32_t question);
/// `question` is done with.
std::string finish(std::uint32_t question);

/// Messages about questions, capabilities and promises that there are not.
std::string odd_protocol(Dice& dice);
/// A call on what another answer promises, or on capabilities that were or were not given.
std::string pipelined_call(Dice& dice, std::uint32_t question);
/// A call whose parameters bring capabilities of ours, and what we then say of them.
std::vector<std::string> calls_with_capabilities(Dice& dice, std::uint32_t question);
/// A call whose parameters are words that point anywhere: beyond the message, at themselves, into
/// depths.
std::string odd_pointers(Dice& dice, std::uint32_t question);
/// A message of any of these kinds with some bytes changed.
std::string mutated(Dice& dice, const Bounds& bounds, std::uint32_t question);
/// A frame whose head says what is not so.
std::string broken_frame(Dice& dice);

}  // namespace sleight::attack
