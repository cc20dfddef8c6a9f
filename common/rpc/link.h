// A client's connection, as watch and fetch see it: blocking calls that say apart how they end.
//
// Thread safety: belongs to the thread of its Client.
#pragma once

#include <cstddef>
#include <cstdint>
#include <exception>
#include <string>
#include <vector>

#include "common/base/bytes.h"
#include "common/rpc/client.h"

namespace sleight::rpc {

/// The connection broke, or could not be made by a server that is there: try again.
class Lost : public std::exception {
 public:
  explicit Lost(std::string words) : words_(std::move(words)) {}
  const char* what() const noexcept override { return words_.c_str(); }

 private:
  std::string words_;
};

/// interrupt() was called.
class Interrupted : public std::exception {};

/// What a watcher lacks of a job, as it came; events are lines, some of which only a newer program
/// understands.
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
  /// The files stay open until the next call of this, or a lost connection.
  virtual ArrivedFiles fetch(const FetchAsk& ask) = 0;
  /// Of the files of the last fetch. REQUIRES: file < their number.
  virtual base::Bytes read(std::size_t file, std::uint64_t offset, std::uint32_t bytes) = 0;
  virtual void pause(double seconds) = 0;
  virtual double now_s() const = 0;
};

/// Waits longer and longer between attempts, until the service has been away for too long.
class Patience {
 public:
  Patience(Link& link, const ClientOptions& options);
  /// After an attempt that failed: pauses, or throws NoServer with these words.
  void again(const std::string& words);
  /// After one that did not.
  void reset();
  /// Has there been a failed attempt since the last good one?
  bool is_away() const { return is_away_; }
  /// Has it answered, or at least been there, at some time?
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
