// Reads archives that may be damaged or hostile. Each archive is read by its own process
// (reader_process.h).
//
// Invariants:
//  1. No file and no failure of its reader can stop the calling program. If a reader crashes,
//     hangs, exceeds a limit or sends an invalid answer, only its archive is lost: reading throws
//     base::Error with ExitCode::bad_archive, "<path>: <reason>". All later reads of that archive
//     throw the same error.
//  2. Answers are untrusted. The type, number and size of elements must be exactly as requested,
//     and names, dimensions and texts must satisfy the rules of hdf5/reader.h.
//  3. If the reader refuses only a part, such as a damaged chunk, reading that part throws the
//     refusal. The reader continues, and other parts can be read.
//
// Thread safety: one thread at a time uses a Source. Different Sources are independent, even if
// they read the same file. Opening is thread-safe.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "common/archive/model.h"
#include "common/archive/remote/reader_process.h"

namespace sleight::archive::remote {

/// Opens an archive in a separate reader process. If the file can't be opened or the reader can't
/// be started, throws base::Error with ExitCode::environment. If the archive is refused or the
/// reader fails, throws base::Error with ExitCode::bad_archive.
std::unique_ptr<Source> open_remote(const std::string& path, const ReaderLimits& limits = {});

/// For tests. Like open_remote, but with the given reader program and without read-ahead.
std::unique_ptr<Source> open_remote_by(const std::string& program, const std::string& path,
                                       const ReaderLimits& limits = {});

struct OpenedArchive {
  std::string path;
  std::unique_ptr<Source> source;  ///< null if refused
  std::string refused;             ///< reason with the path; empty if open
};

/// Opens each archive. Results are in the order of `paths`. If one archive fails, the others are
/// still opened. Several archives are opened at a time, so that a hanging one delays the others by
/// at most one time limit.
std::vector<OpenedArchive> open_all(std::span<const std::string> paths,
                                    const ReaderLimits& limits = {});
std::vector<OpenedArchive> open_all_by(const std::string& program,
                                       std::span<const std::string> paths,
                                       const ReaderLimits& limits = {});

}  // namespace sleight::archive::remote
