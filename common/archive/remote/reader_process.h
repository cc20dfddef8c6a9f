// A process that reads one archive for us (archive/reader_program), and the pipes to it.
//
// HDF5 1.10.8 has known faults that a damaged or hostile file can reach from H5Fopen on. So each
// archive is read in a process of its own, which has given up everything but reading that file and
// answering before it looks at it; what becomes of the process is no harm to this one.
//
// The process is started as one may be in a program of many threads: not by fork, but by
// posix_spawn, which between the two runs nothing of ours. It has no descriptors but its own, a
// cleaned environment, and no signals from the terminal. It ends when this object does, or when
// this process does, however that ends: the kernel then closes its lifeline.
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
  /// The process' whole address space. Not enforced under a sanitizer, whose own maps need more
  /// than any limit.
  std::uint64_t address_space_bytes = std::uint64_t{4} << 30;
  std::uint32_t cpu_s = 600;  ///< processor time of one question, and of opening
  double timeout_s = 900;     ///< time on the wall of one question, and of opening
};

/// How far an answer came.
enum class Received { all, ended, late };

struct ReaderEnd {
  std::string words{};  ///< for people
  base::ExitCode exit_code = base::ExitCode::bad_archive;
  bool is_abrupt = false;  ///< as for want of memory
};

class ReaderProcess {
 public:
  /// Starts `program` on an archive that is open for reading, which stays the caller's. Throws
  /// base::Error when it can't be started.
  ReaderProcess(const std::string& program, int archive, const ReaderLimits& limits);
  ReaderProcess(const ReaderProcess&) = delete;
  ReaderProcess& operator=(const ReaderProcess&) = delete;
  /// Ends it.
  ~ReaderProcess();

  /// From now on the limits of a new question hold.
  void renew_limits();
  /// Sends a question. False when the process has gone.
  bool send(std::span<const std::byte> bytes);
  /// Fills `bytes` with the next that the process says.
  Received receive(std::span<std::byte> bytes);
  /// Whether it says, or has said, what nobody has asked for.
  bool has_unasked_words() const;

  /// Ends the process if it doesn't end by itself at once, and says why it is no more.
  /// REQUIRES: once, and nothing else afterwards.
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
  std::chrono::steady_clock::time_point renewed_{};  ///< when its processor time was
};

/// `sleight-reader` beside the running program.
std::string reader_beside_this_program();

}  // namespace sleight::archive::remote
