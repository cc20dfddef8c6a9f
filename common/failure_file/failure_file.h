// A file that reproduces a failed simulation: `sleight replay FILE`.
//
//   # A simulation that failed. `sleight replay FILE` repeats the simulation.
//   [failure]
//   program_version = "0.1.0+g4023dc0a1b2c"
//   kind = "search_gave_up"
//   message = "body 'die 1': collision search gave up at tick 1048576 (0.0009765625 s)"
//   chain = 0
//   replica = 3
//   scan = 1760
//   state = "00ff..."
//   checksum = "9ae16a3b2f90404f"
//   [world]
//   ...
//
// The state is hexadecimal, in the world's own encoding. From [world] on, the file contains the
// whole request as `sleight check` prints it. The checksum is FNV-1a (64 bits) of all other lines.
// Without a checksum, a damaged file could look like a simulation that now succeeds. A file without
// a checksum is accepted, so that people can edit it. The file is TOML and untrusted. Thread
// safety: pure functions.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "common/base/result.h"
#include "common/plan/unit.h"
#include "common/request/diagnostic.h"

namespace sleight::failure_file {

struct FailureFile {
  std::string program_version;
  std::string request_text;  ///< padded with empty lines to keep the file's line numbers
  plan::ReplicaKey replica;
  plan::FailedSimulation failed;
};

std::string to_text(const FailureFile& file);

/// Returns the file's content, or the reason why it is invalid. Does not parse the request.
base::Result<FailureFile, request::Diagnostic> read(std::string_view text, const std::string& path);

/// Returns the file name for a failure at this place in the run: "failure-0-3-1760.toml" is chain
/// 0, replica 3, scan 1760. `nth`: index among the scan's failures. For the first failure, the name
/// does not contain `nth`.
std::string name_of(const plan::ReplicaKey& replica, base::ScanIndex scan, std::size_t nth);

}  // namespace sleight::failure_file
