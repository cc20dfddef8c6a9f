// A separate process that reads one archive for this process (archive/reader_program), and the
// pipes between the two processes.
//
// A damaged or hostile file can trigger known faults of HDF5 1.10.8, as early as in H5Fopen. So
// each archive is read in a separate process. Before the reader process reads anything from the
// file, it drops all rights except reading the file and answering. So nothing that happens in the
// reader process can harm the calling process.
//
// The process is started by posix_spawn, because fork is unsafe in a multi-threaded program. With
// posix_spawn, none of our code runs in the new process before `program`. The process has only its
// own descriptors, a clean environment, and no signals from the terminal. The process ends when
// this object is destroyed, or when this process ends in any way, because the kernel then closes
// its lifeline.
//
// Not thread-safe; different objects are independent of each other.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "common/base/descriptor.h"
#include "common/base/error.h"

namespace sleight::archive::remote {

struct ReaderLimits {
  /// Limit of the process's address space. Under a sanitizer the limit is not enforced, because the
  /// sanitizer's own memory maps exceed any limit.
  std::uint64_t address_space_bytes = std::uint64_t{4} << 30;
  std::uint32_t cpu_s = 600;  ///< processor time per question, and for opening
  double timeout_s = 900;     ///< wall-clock time per question, and for opening
};

enum class Received { all, ended, late };

struct ReaderEnd {
  std::string words{};
  base::ExitCode exit_code = base::ExitCode::bad_archive;
  bool is_abrupt = false;  ///< such as out of memory
};

class ReaderProcess {
 public:
  /// Starts `program` and gives it a copy of the descriptor `archive`. The caller keeps and owns
  /// `archive`. Throws base::Error if the process can't be started.
  ReaderProcess(const std::string& program, int archive, const ReaderLimits& limits);
  ReaderProcess(const ReaderProcess&) = delete;
  ReaderProcess& operator=(const ReaderProcess&) = delete;
  ~ReaderProcess();

  /// Restarts the limits for a new question.
  void renew_limits();
  /// Sends a question. False if the process has exited.
  bool send(std::span<const std::byte> bytes);
  /// Fills `bytes` with the next bytes from the process.
  Received receive(std::span<std::byte> bytes);
  /// Returns whether the process has sent bytes that nobody requested.
  bool has_unasked_words() const;

  /// Returns the reason why the process ended. If the process does not exit by itself soon, kills
  /// it. REQUIRES: no other function is called afterwards, except for the destructor.
  ReaderEnd end();

  pid_t id() const { return id_; }

 private:
  void limit_processor_time() const;

  ReaderLimits limits_;
  base::Descriptor questions_;
  base::Descriptor answers_;
  base::Descriptor lifeline_;
  pid_t id_ = -1;
  std::chrono::steady_clock::time_point deadline_{};
  std::chrono::steady_clock::time_point renewed_{};  ///< last start of the processor-time limit
};

/// Returns the path of `sleight-reader` beside the running program.
std::string reader_beside_this_program();

}  // namespace sleight::archive::remote
