// A client's connection for watch and fetch. A Link's calls block. Each kind of failure has its own
// exception.
//
// Thread safety: a Link belongs to its Client's thread.
#pragma once

#include <cstddef>
#include <cstdint>
#include <exception>
#include <string>
#include <vector>

#include "common/base/bytes.h"
#include "common/rpc/client.h"

namespace sleight::rpc {

/// Thrown if the connection broke, or if a running server could not accept it. The caller retries.
class Lost : public std::exception {
 public:
  explicit Lost(std::string words) : words_(std::move(words)) {}
  const char* what() const noexcept override { return words_.c_str(); }

 private:
  std::string words_;
};

class Interrupted : public std::exception {};

/// A job's events and state changes, as they were received. Events are JSON lines, because a newer
/// service may send types of events that this program doesn't know.
struct ArrivedBatch {
  JobId job{};
  std::optional<Refusal> refusal{};
  std::vector<StateChange> changes{};
  std::vector<std::pair<std::uint64_t, std::string>> events{};  ///< number and line
  std::uint64_t mark = 0;
  bool settled = false;
};

struct ArrivedFiles {
  std::vector<FileView> files{};
  bool has_more = false;
};

/// Every function throws Lost, Interrupted, NoServer, RefusedError or base::Error.
class Link {
 public:
  virtual ~Link() = default;
  virtual std::vector<ArrivedBatch> watch(const std::vector<WatchPoint>& points) = 0;
  /// The files stay open until the next fetch(), or until the connection is lost.
  virtual ArrivedFiles fetch(const FetchAsk& ask) = 0;
  /// Reads from a file of the last fetch. REQUIRES: `file` is an index into that fetch's files.
  virtual base::Bytes read(std::size_t file, std::uint64_t offset, std::uint32_t bytes) = 0;
  virtual void pause(double seconds) = 0;
  virtual double now_s() const = 0;
};

/// Waits with growing delays between attempts, until the service has been away for too long.
class Patience {
 public:
  Patience(Link& link, const ClientOptions& options);
  /// Call after a failed attempt. Pauses, or throws NoServer if the service was away too long.
  void again(const std::string& words);
  /// Call after a successful attempt.
  void reset();
  /// Returns whether the last attempt failed.
  bool is_away() const { return is_away_; }
  /// Returns whether the service has ever answered, or was ever seen running.
  bool was_there() const { return was_there_; }

 private:
  Link& link_;
  ClientOptions options_;
  double wait_s_;
  double away_since_s_ = 0;
  bool is_away_ = false;
  bool was_there_ = false;
};

Waited watch_over(Link& link, const ClientOptions& options, const std::vector<WatchPoint>& points,
                  WatchSink& sink);
FetchedFiles fetch_file_over(Link& link, const ClientOptions& options, FetchAsk ask,
                             const std::string& path, const FetchProgress& progress,
                             const FetchCheck& check, AtItsPlace other);
FetchedFiles fetch_folder_over(Link& link, const ClientOptions& options, FetchAsk ask,
                               const std::string& folder, const FetchProgress& progress,
                               AtItsPlace other);

}  // namespace sleight::rpc
