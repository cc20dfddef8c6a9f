// Provides a job's files for fetching: its newest archive, an archive derived on request,
// recordings of kept animations, and failed simulations.
//
// Hashing and deriving are slow, so worker threads do them. An announced file is kept for a while.
// So a client can fetch the rest of the file later, even if the run has meanwhile written a newer
// file.
//
// Thread safety: only the loop's thread makes calls; `folders`, `loop` and `worker` must outlive
// the object.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <variant>
#include <vector>

#include "common/base/clock.h"
#include "common/rpc/handler.h"
#include "common/rpc/loop.h"
#include "service/daemon/job_folder.h"
#include "service/daemon/worker.h"
#include "service/keeper/tool.h"

namespace sleight::daemon {

/// Maximum kept files. A client that lost its connection can fetch the rest of a kept file.
inline constexpr std::size_t k_held_files_max = 16;
/// Maximum derived files of one name. An active job's archive is different each time.
inline constexpr std::size_t k_held_made_max = 2;
inline constexpr double k_held_for_s = 600;
/// Maximum unfinished fetches of a user. If a client disconnects, its fetch continues.
inline constexpr std::size_t k_fetches_of_user_max = 32;
/// Maximum time for deriving an archive or recordings.
inline constexpr double k_make_s_max = 900;

class Fetching {
 public:
  struct Parts {
    rpc::Loop& loop;
    Worker& worker;  ///< hashes existing files
    Worker& maker;   ///< derives missing ones, which is slower; only such fetches wait for it
    const JobFolders& folders;
    std::string sleight{};  ///< the program that makes archives and recordings
  };
  explicit Fetching(Parts parts);
  /// Waits until both workers have finished their current work, because it uses this object.
  ~Fetching();
  Fetching(const Fetching&) = delete;
  Fetching& operator=(const Fetching&) = delete;

  /// Answers a user's fetch. `segments` names the archive's table of recordings (draws or finds).
  void fetch(std::uint32_t user, const rpc::FetchAsk& ask, std::string segments,
             rpc::Reply<rpc::Fetched> reply);

  /// A file on the disk and the name that clients see. `is_ours`: derived for this fetch.
  struct Found {
    std::string path;
    std::string name;
    bool is_ours = false;
  };

 private:
  struct Hashed {
    Found file;
    std::string sha256;
  };
  /// A link to a file that clients may request again.
  struct Held {
    std::string path;
    std::string name;
    bool is_ours = false;  ///< derived, so nobody else has the same bytes
    double until_s = 0;
  };

  using Files = std::variant<std::vector<Found>, rpc::Refusal>;

  // In the worker's thread. `made`: where to put a derived file.
  Files find(const rpc::FetchAsk& ask, const std::string& segments, const std::string& beside,
             bool& has_more) const;
  Files newest(jobs::JobId job, const std::string& made) const;
  keeper::ToolEnd run_maker(const std::vector<std::string>& command) const;
  Files derived(jobs::JobId job, const std::string& made) const;
  Files recordings(jobs::JobId job, const std::string& segments,
                   const std::vector<std::uint64_t>& ids, const std::string& made) const;
  std::vector<Found> failures(jobs::JobId job, const std::string& after, bool& has_more) const;
  static Hashed hashed(Found file, const std::string& beside);

  void make(std::uint32_t user, const rpc::FetchAsk& ask, const std::string& segments,
            std::shared_ptr<rpc::Reply<rpc::Fetched>> reply);
  void give(std::vector<Hashed> files, bool has_more, rpc::Reply<rpc::Fetched>& reply);
  std::unique_ptr<rpc::Source> held(const std::string& sha256);
  void hold(const std::string& sha256, const Found& file);
  using HeldFile = std::map<std::string, Held>::iterator;
  HeldFile drop(HeldFile held);
  void drop_oldest(const std::function<bool(const Held&)>& is_meant, std::size_t most);
  void drop_expired();

  Parts parts_;
  base::SteadyClock clock_;
  std::map<std::string, Held> held_{};                ///< by digest
  std::map<std::uint32_t, std::size_t> under_way_{};  ///< fetches by user
  std::uint64_t made_ = 0;
  rpc::Loop::Handle expiry_;
};

/// Hexadecimal SHA-256 of a file's bytes. Throws base::Error if the file can't be read.
std::string sha256_of_file(const std::string& path);

}  // namespace sleight::daemon
