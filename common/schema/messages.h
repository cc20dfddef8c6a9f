// worker.capnp as values: what a batch job's ranks send, encoded and decoded.
//
// Decoding trusts nothing: a message of an unknown kind, with parts that don't fit each other, or
// that can't be read within the limits is refused with a reason.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <variant>
#include <vector>

#include "common/base/bytes.h"
#include "common/base/result.h"
#include "common/plan/block.h"

namespace sleight::schema {

/// Larger messages are refused on both sides: a unit is cut long before.
inline constexpr std::size_t k_message_bytes_max = std::size_t{1} << 30U;

struct Hello {
  std::string program_version;
  std::string identity;
  std::uint32_t threads = 1;  ///< that compute
};
struct Assignment {
  std::uint64_t epoch = 0;
  std::uint64_t assignment = 0;
  plan::Block block;
  std::vector<plan::GivenState> states;  ///< of each member
};
/// Results have of their units only replica, first scan and number of scans.
struct Delivery {
  std::uint64_t epoch = 0;
  std::uint64_t assignment = 0;
  std::vector<plan::UnitResult>
      results;  ///< of each member; none: a state is neither given nor held
  plan::CacheUse cache;
};
struct Ping {
  std::uint64_t epoch = 0;
};
struct Pong {
  std::uint64_t epoch = 0;
  std::vector<std::uint64_t> assignments;  ///< that are before the worker
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

using Message = std::variant<Hello, Assignment, Stop, Delivery, Ping, Pong, Failure>;

base::Bytes encode(const Message& message);

/// The message, or why it can't be one.
base::Result<Message, std::string> decode(base::BytesView bytes);

}  // namespace sleight::schema
