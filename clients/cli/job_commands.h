// The commands on jobs that are one call or a few: list, status, watch, wait, delete, and the
// changes cancel, hold, resume, extend, pin and priority. Each takes the socket's path and what the
// command line gave, prints to stdout and returns the exit code.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/rpc/service.h"

namespace sleight::cli {

struct ListOptions {
  std::vector<std::string> states{};
  bool mine = false;
  std::string user{};   ///< a name or a uid; empty: all that the caller may see
  std::string group{};  ///< "g5"; empty: any
  std::string name{};   ///< a part of the name
  std::uint32_t count = 50;
  bool all = false;  ///< whatever `count` says
  bool oldest_first = false;
  std::string after{};    ///< the cursor of the page before
  bool complete = false;  ///< for shells: never an error, never a message
  bool json = false;
};

/// What most commands have: jobs as people name them, and how to print.
struct JobsOptions {
  std::vector<std::string> jobs{};
  bool json = false;
};

struct StatusOptions : JobsOptions {
  bool history = false;
};

struct WatchOptions : JobsOptions {
  std::uint64_t from_number = 1;
};

/// Exactly one of the numbers.
struct ExtendOptions : JobsOptions {
  std::optional<std::uint64_t> scans{};
  std::optional<std::uint32_t> rounds{};
  std::optional<std::uint32_t> solutions{};
  std::optional<double> odds{};
};

struct DeleteOptions : JobsOptions {
  bool yes = false;  ///< does not ask
};

int list_jobs(const std::string& socket, const ListOptions& options);
int show_status(const std::string& socket, const StatusOptions& options);
int watch(const std::string& socket, const WatchOptions& options);
int wait(const std::string& socket, const JobsOptions& options);
/// Changes each of the named jobs, whatever target `ask` has.
int change(const std::string& socket, const JobsOptions& options, const rpc::ChangeAsk& ask);
/// Refuses all where one of them has not ended or is pinned; asks back on a terminal.
int delete_jobs(const std::string& socket, const DeleteOptions& options);

/// Throws base::Error(usage) where not exactly one is given, or it is none that a request may have.
rpc::Extension extension_of(const ExtendOptions& options);

/// Throws base::Error(usage) for a state or user that is none.
rpc::ListAsk list_ask_of(const ListOptions& options);

}  // namespace sleight::cli
