// The main function of a reader process. Tests also start misbehaving readers with this function,
// so that the same limits apply to them.
#pragma once

#include <cstdint>
#include <functional>

namespace sleight::archive::reader_program {

struct Given {
  std::uint64_t memory_bytes = 0;
  std::uint64_t archive_bytes = 0;
};

/// Prepares the process, confines it (confine.h) and runs `work`. The result of `work` is the
/// process's exit code.
int run_confined(int argc, const char* const* argv, const std::function<int(const Given&)>& work);

/// The `work` of `sleight-reader`.
int read_and_answer(const Given& given);

}  // namespace sleight::archive::reader_program
