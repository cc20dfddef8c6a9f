// A reader process' part of the conversation that archive/remote/messages.h describes: says what is
// in an archive, then answers questions until nobody asks any more.
//
// Not thread-safe.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>

#include "common/archive/model.h"
#include "common/archive/remote/messages.h"

namespace sleight::archive::reader_program {

/// An archive's name in the reader's messages, which it leaves out of what it says: the program
/// that asks knows it, and the reader need not.
inline constexpr const char* k_nameless = "archive";

/// Opens the archive, and answers. Returns the process' exit code. What `open` throws is a refusal:
/// base::Error and std::bad_alloc. `memory_bytes`: how much there is, for words.
int answer(const std::function<std::unique_ptr<Source>()>& open, std::uint64_t memory_bytes);

/// Says it all, to the answers' descriptor. False where nobody listens any more.
bool say(const remote::AnswerHead& head, std::span<const std::byte> bytes);
/// Waits for a question. False where nobody asks any more.
bool hear(remote::Question& question);

}  // namespace sleight::archive::reader_program
