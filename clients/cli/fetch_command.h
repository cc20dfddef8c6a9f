// `sleight fetch`: copies archives, recordings and failure files of jobs into local files.
//
// A file arrives in pieces. A complete file is checked against its digest and renamed. An
// interrupted fetch is resumed (rpc::Client). An existing file with the same bytes counts as
// fetched. If an existing file has other bytes, it is replaced only if --force is given.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/rpc/service.h"

namespace sleight::cli {

/// Checks that a fetched archive is the one that the job wrote: the transfer's checksum only covers
/// the file on the server's disk, where it may have been damaged. Verifies the file
/// (archive/digest/verify.h), and compares its digest with a finished job's digest. Prints what is
/// wrong to stderr and throws base::Error (bad_archive). REQUIRES: no other thread runs, because a
/// child process reads the file.
void check_archive(const std::string& path, const rpc::JobView& job);

struct FetchOptions {
  std::vector<std::string> jobs{};
  std::string output{};      ///< a file, or a folder for several jobs; empty: named after the job
  bool so_far = false;       ///< only what is committed by now
  std::string recordings{};  ///< "3,7,10..20"
  bool failures = false;
  bool force = false;  ///< replaces existing files
  bool quiet = false;
  bool json = false;
};

/// Checks an archive before it is renamed to its place. Throws base::Error to refuse the archive.
/// Programs use check_archive.
using ArchiveCheck = std::function<void(const std::string& path, const rpc::JobView& job)>;

int fetch(const std::string& socket, const FetchOptions& options, const ArchiveCheck& check);

/// Returns the numbers in a text such as "3,7,10..20", in order and without duplicates. Returns
/// nothing if the text is invalid or has more than rpc::k_fetch_ids_max numbers.
std::optional<std::vector<std::uint64_t>> recording_ids_of(std::string_view text);

/// Throws base::Error(usage) if two options can't be combined.
rpc::FetchAsk fetch_ask_of(const FetchOptions& options);

/// Returns where a job's result is stored: a file for an archive, otherwise a folder. `several`:
/// the output folder has a separate place for each job. `group`: set if only one group was named.
/// The group becomes part of the folder's name.
std::string place_of(const FetchOptions& options, rpc::JobId job, bool several,
                     const std::optional<rpc::GroupId>& group);

}  // namespace sleight::cli
