// The reader process's part in the protocol of archive/remote/messages.h. The process sends the
// archive's contents, then answers questions until the pipe is closed.
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

/// The archive's name in the reader's messages. The reader removes the name before sending, because
/// only the client knows the path.
inline constexpr const char* k_nameless = "archive";

/// Opens the archive and answers questions. Returns the process's exit code. Exceptions base::Error
/// and std::bad_alloc from `open` are sent as refusals. `memory_bytes`: memory limit, for messages.
int answer(const std::function<std::unique_ptr<Source>()>& open, std::uint64_t memory_bytes);

/// Writes an answer completely to the answers' descriptor. False: nobody reads any more.
bool say(const remote::AnswerHead& head, std::span<const std::byte> bytes);
/// Waits for a question. False: nobody asks any more.
bool hear(remote::Question& question);

}  // namespace sleight::archive::reader_program
