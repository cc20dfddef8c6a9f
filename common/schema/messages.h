// The messages that a batch job's ranks exchange, as plain values. wire/ encodes and decodes them.
#pragma once

#include <cstdint>
#include <string>
#include <variant>
#include <vector>

#include "common/plan/block.h"

namespace sleight::schema {

struct Hello {
  std::string results_version;
  std::string identity;
  std::uint32_t threads = 1;  ///< computing threads
};
struct Assignment {
  std::uint64_t epoch = 0;
  std::uint64_t assignment = 0;
  plan::Block block;
  std::vector<plan::GivenState> states;  ///< by member
};
/// In each result, `unit` contains only the replica, the first scan and the number of scans.
struct Delivery {
  std::uint64_t epoch = 0;
  std::uint64_t assignment = 0;
  std::vector<plan::UnitResult> results;  ///< by member; empty: a state is missing
  plan::CacheUse cache;
};
struct Ping {
  std::uint64_t epoch = 0;
};
struct Pong {
  std::uint64_t epoch = 0;
  std::vector<std::uint64_t> assignments;  ///< outstanding
};
struct Stop {};
struct Failure {
  std::string reason;
};

using Message = std::variant<Hello, Assignment, Stop, Delivery, Ping, Pong, Failure>;

}  // namespace sleight::schema
