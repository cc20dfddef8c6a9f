// The whole of a reader process, but for what it answers with: its main, and those of tests which
// behave badly under the same limits.
#pragma once

#include <cstdint>
#include <functional>

namespace sleight::archive::reader_program {

/// What a reader process has.
struct Given {
  std::uint64_t memory_bytes = 0;
  std::uint64_t archive_bytes = 0;  ///< length of the file that it is to read
};

/// What a main does: takes its place, gives everything up (confine.h), and then runs `work`, with
/// whose exit code the process ends.
int run_confined(int argc, const char* const* argv, const std::function<int(const Given&)>& work);

/// The work of `sleight-reader`.
int read_and_answer(const Given& given);

}  // namespace sleight::archive::reader_program
