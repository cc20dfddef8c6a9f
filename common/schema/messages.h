// What a batch job's ranks say to each other, as plain values; wire/ encodes and decodes them.
#pragma once

#include <cstdint>
#include <string>
#include <variant>
#include <vector>

#include "common/plan/block.h"

namespace sleight::schema {

struct Hello {
  std::string results_version;  ///< of the program
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

using Message = std::variant<Hello, Assignment, Stop, Delivery, Ping, Pong, Failure>;

}  // namespace sleight::schema
