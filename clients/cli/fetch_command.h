// `sleight fetch`: archives, recordings and files of failures of jobs, into files here.
//
// A file comes in pieces, is checked against its digest and renamed when it is whole; what an
// earlier attempt left is gone on with (rpc::Client). A file that is there already is left alone:
// if it has the same bytes, the fetch is done; else it is refused without --force.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/rpc/service.h"

namespace sleight::cli {

struct FetchOptions {
  std::vector<std::string> jobs{};
  std::string output{};      ///< a file, of several a folder; empty: named by the job
  bool so_far = false;       ///< of what is committed by now
  std::string recordings{};  ///< "3,7,10..20"
  bool failures = false;
  bool force = false;  ///< replaces files that are there
  bool quiet = false;
  bool json = false;
};

/// Refuses an archive by throwing base::Error, before it takes its place; check_archive of
/// fetched_archive.h, but in tests.
using ArchiveCheck = std::function<void(const std::string& path, const rpc::JobView& job)>;

int fetch(const std::string& socket, const FetchOptions& options, const ArchiveCheck& check);

/// Numbers of "3,7,10..20", in order, each once; none for anything else, or more than
/// rpc::k_fetch_ids_max.
std::optional<std::vector<std::uint64_t>> recording_ids_of(std::string_view text);

/// Throws base::Error(usage) where options exclude each other.
rpc::FetchAsk fetch_ask_of(const FetchOptions& options);

/// Where what a job gives lies: a file of an archive, else a folder. `several`: jobs, of which each
/// has a place in the output's folder. `group`: was named alone, and names the folder.
std::string place_of(const FetchOptions& options, rpc::JobId job, bool several,
                     const std::optional<rpc::GroupId>& group);

}  // namespace sleight::cli
