// worker.capnp: how the messages of messages.h travel, as MPI messages in Cap'n Proto's encoding.
//
// Decoding trusts nothing: a message of an unknown kind, with parts that don't fit each other, or
// that can't be read within the limits is refused with a reason.
#pragma once

#include <cstddef>
#include <string>

#include "common/base/bytes.h"
#include "common/base/result.h"
#include "common/schema/messages.h"

namespace sleight::schema::wire {

/// Larger messages are refused on both sides: a unit is cut long before.
inline constexpr std::size_t k_message_bytes_max = std::size_t{1} << 30U;

/// All messages of a job carry this MPI tag.
inline constexpr int k_message_tag = 1;
/// A rank that waits for a message looks for it at intervals that double between these two: a
/// blocking receive would take a whole core, these take under 2% of one.
inline constexpr double k_poll_interval_s_min = 20e-6;
inline constexpr double k_poll_interval_s_max = 2e-3;

base::Bytes encode(const Message& message);

/// The message, or why it can't be one.
base::Result<Message, std::string> decode(base::BytesView bytes);

}  // namespace sleight::schema::wire
