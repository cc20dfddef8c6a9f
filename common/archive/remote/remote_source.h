// Archives that may be damaged or hostile, read by a process each (reader_process.h).
//
// Invariants:
//  1. Whatever the file holds and whatever becomes of its reader, the program that asks goes on: a
//     reader that crashes, hangs, takes too much or says what can't be costs its archive alone, as
//     a base::Error with ExitCode::bad_archive, "<path>: <reason>". From then on each question to
//     it throws the same.
//  2. An answer is checked like any stranger's: type, number and size of elements are exactly
//     what was asked for, names, dimensions and texts are such as hdf5/reader.h lets through.
//  3. What the reader refuses of a sound file (a chunk that is damaged) is thrown too, but the
//     reader stays: other parts may be read.
//
// Thread safety: one thread at a time uses a Source; different ones are independent, also when they
// are of one file. Opening is thread-safe.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "common/archive/model.h"
#include "common/archive/remote/reader_process.h"

namespace sleight::archive::remote {

/// Opens an archive in a process of its own. Throws base::Error: ExitCode::environment where the
/// file or the reader can't be opened or started, bad_archive as above.
std::unique_ptr<Source> open_remote(const std::string& path, const ReaderLimits& limits = {});

/// The same by another reader than the one beside the running program, and each question as it is
/// asked (no read_ahead.h): for tests.
std::unique_ptr<Source> open_remote_by(const std::string& program, const std::string& path,
                                       const ReaderLimits& limits = {});

/// An archive's place in a list.
struct OpenedArchive {
  std::string path;
  std::unique_ptr<Source> source;  ///< null where it is refused
  std::string refused;             ///< why, naming the path; empty where it is open
};

/// Each in its place, in the order of `paths`: one that can't be opened costs no other. Several are
/// opened at a time, so that one that hangs keeps the others waiting for one time limit at most.
std::vector<OpenedArchive> open_all(std::span<const std::string> paths,
                                    const ReaderLimits& limits = {});
std::vector<OpenedArchive> open_all_by(const std::string& program,
                                       std::span<const std::string> paths,
                                       const ReaderLimits& limits = {});

}  // namespace sleight::archive::remote
