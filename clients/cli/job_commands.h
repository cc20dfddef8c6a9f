// The simple commands on jobs: list, status, watch, wait, delete, and the changes cancel, hold,
// resume, extend, pin and priority. Each function takes the socket's path and the options, prints
// to stdout and returns the exit code.
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
  std::string user{};   ///< a name or a uid; empty: all visible jobs
  std::string group{};  ///< such as "g5"; empty: any
  std::string name{};   ///< part of the name
  std::uint32_t count = 50;
  bool all = false;  ///< ignores `count`
  bool oldest_first = false;
  std::string after{};    ///< cursor of the previous page
  bool complete = false;  ///< for shell completion: no errors, no messages
  bool json = false;
};

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

/// Exactly one number is set.
struct ExtendOptions : JobsOptions {
  std::optional<std::uint64_t> scans{};
  std::optional<std::uint32_t> rounds{};
  std::optional<std::uint32_t> solutions{};
  std::optional<double> odds{};
};

struct DeleteOptions : JobsOptions {
  bool yes = false;  ///< doesn't ask for confirmation
};

int list_jobs(const std::string& socket, const ListOptions& options);
int show_status(const std::string& socket, const StatusOptions& options);
int watch(const std::string& socket, const WatchOptions& options);
int wait(const std::string& socket, const JobsOptions& options);
/// Changes each named job. Ignores the target in `ask`.
int change(const std::string& socket, const JobsOptions& options, const rpc::ChangeAsk& ask);
/// Refuses to delete any job if one is unfinished or pinned. Asks for confirmation on a terminal.
int delete_jobs(const std::string& socket, const DeleteOptions& options);

/// Throws base::Error(usage) unless exactly one number is set and its value is allowed in requests.
rpc::Extension extension_of(const ExtendOptions& options);

/// Throws base::Error(usage) for an unknown state or user.
rpc::ListAsk list_ask_of(const ListOptions& options);

}  // namespace sleight::cli
