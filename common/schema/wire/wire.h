// Encodes and decodes the messages of messages.h as MPI messages in Cap'n Proto's encoding
// (worker.capnp).
//
// Decoding refuses a message if its kind is unknown, its parts are inconsistent, or it exceeds a
// limit. The refusal gives the reason.
#pragma once

#include <cstddef>
#include <string>

#include "common/base/bytes.h"
#include "common/base/result.h"
#include "common/schema/messages.h"

namespace sleight::schema::wire {

/// Both sides refuse larger messages. Units are split long before their messages reach this size.
inline constexpr std::size_t k_message_bytes_max = std::size_t{1} << 30U;

inline constexpr int k_message_tag = 1;
/// A waiting rank polls. The interval doubles after each poll, from the minimum to the maximum. A
/// blocking receive would use a whole core; polling uses less than 2% of a core.
inline constexpr double k_poll_interval_s_min = 20e-6;
inline constexpr double k_poll_interval_s_max = 2e-3;

base::Bytes encode(const Message& message);

/// Returns the message, or the reason why the bytes are invalid.
base::Result<Message, std::string> decode(base::BytesView bytes);

}  // namespace sleight::schema::wire
