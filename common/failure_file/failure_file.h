// A failed simulation as a file that repeats it: `sleight replay FILE`.
//
//   # A simulation that failed. `sleight replay FILE` repeats it.
//   [failure]
//   program_version = "0.1.0+g4023dc0a1b2c"
//   kind = "search_gave_up"
//   message = "die 1: the search for a collision gives up at tick 1048576 (0.000976562 s)"
//   chain = 0
//   replica = 3
//   scan = 1760
//   state = "00ff..."
//   checksum = "9ae16a3b2f90404f"
//   [world]
//   ...
//
// The state is hexadecimal, in the world's own encoding; from [world] on stands the whole request,
// as `sleight check` prints it. The checksum is FNV-1a (64 bits) of all other lines, so that a file
// that was damaged is not taken for a simulation that succeeds by now; a file without that line is
// taken as it is, so that a person may change one on purpose. The file is TOML and may come from
// anywhere: reading trusts nothing. Thread safety: pure functions.
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
  std::string request_text;  ///< as it stands in the file, behind as many lines as there
  plan::ReplicaKey replica;
  plan::FailedSimulation failed;
};

std::string to_text(const FailureFile& file);

/// The file, or what is wrong with it. The request is not looked into.
base::Result<FailureFile, request::Diagnostic> read(std::string_view text, const std::string& path);

/// What the file of a failure is called, by where in the run it happened: "failure-0-3-1760.toml"
/// is of chain 0, replica 3, scan 1760. `nth` of that scan, from 0; the first has no number.
std::string name_of(const plan::ReplicaKey& replica, base::ScanIndex scan, std::size_t nth);

}  // namespace sleight::failure_file
