// worker.capnp as values: what a batch job's ranks send, encoded and decoded.
//
// Decoding trusts nothing: a message of the wrong kind, with a unit whose result has another
// length, or that can't be read within the limits is refused with a reason.
#pragma once

#include <cstddef>
#include <string>
#include <variant>

#include "common/base/bytes.h"
#include "common/base/result.h"
#include "common/plan/unit.h"

namespace sleight::schema {

/// Larger messages are refused on both sides: a unit is cut long before.
inline constexpr std::size_t k_message_bytes_max = std::size_t{1} << 30U;

struct Hello {
  std::string program_version;
  std::string identity;
};
struct Assignment {
  plan::Unit unit;
  base::Bytes state;
};
struct Stop {};
struct Failure {
  std::string reason;
};

/// All messages of a job carry this MPI tag.
inline constexpr int k_message_tag = 1;
/// A rank that waits for a message looks for it at intervals that double between these two: a
/// blocking receive would take a whole core, these take under 2% of one.
inline constexpr double k_poll_interval_s_min = 20e-6;
inline constexpr double k_poll_interval_s_max = 2e-3;

using Message = std::variant<Hello, Assignment, Stop, plan::UnitResult, Failure>;

base::Bytes encode(const Message& message);

/// The message, or why it can't be one.
base::Result<Message, std::string> decode(base::BytesView bytes);

}  // namespace sleight::schema
