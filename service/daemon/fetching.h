// The files of a job that clients fetch: its newest archive, one made now, recordings of kept
// animations, simulations that failed.
//
// Hashing and making take long and are a worker thread's; a file that was announced once stays open
// for a while, so that a client that comes back for the rest finds it even if the run has written a
// newer one.
//
// Thread safety: all on the loop's thread; `folders`, `loop` and `worker` must outlive it.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "common/base/clock.h"
#include "common/rpc/handler.h"
#include "common/rpc/loop.h"
#include "service/daemon/job_folder.h"
#include "service/daemon/worker.h"
#include "service/keeper/tool.h"

namespace sleight::daemon {

/// Files that are held open for clients that come back.
inline constexpr std::size_t k_held_files_max = 16;
/// Of a job that goes on, of which there is another archive so far each time.
inline constexpr std::size_t k_held_made_max = 2;
inline constexpr double k_held_for_s = 600;
/// A user's fetches that are hashed or made, or wait for that: they go on when their client leaves.
inline constexpr std::size_t k_fetches_of_user_max = 32;
/// Of deriving an archive so far, or recordings out of one.
inline constexpr double k_make_s_max = 900;

class Fetching {
 public:
  struct Parts {
    rpc::Loop& loop;
    Worker& worker;  ///< hashes what is there
    Worker& maker;   ///< makes what is not, which takes longer: nobody else waits for that
    const JobFolders& folders;
    std::string sleight{};  ///< the program that makes archives and recordings
  };
  explicit Fetching(Parts parts);
  /// Both workers do what they had begun, which uses this, and nothing more.
  ~Fetching();
  Fetching(const Fetching&) = delete;
  Fetching& operator=(const Fetching&) = delete;

  /// For a user. `segments` names the archive's table of recordings: of its draws, or of finds
  /// where a search is all.
  void fetch(std::uint32_t user, const rpc::FetchAsk& ask, std::string segments,
             rpc::Reply<rpc::Fetched> reply);

  /// A file on the disk and what it is to be called; `is_ours`: made for this call.
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
  /// Of a file that may be asked for again: a link to it.
  struct Held {
    std::string path;
    std::string name;
    bool is_ours = false;  ///< made, so that its bytes are nobody else's
    double until_s = 0;
  };

  using Files = std::variant<std::vector<Found>, rpc::Refusal>;

  // In the worker's thread. `made` is where a file that is made is put.
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

/// Hexadecimal SHA-256 of a file's bytes. Throws base::Error where it can't be read.
std::string sha256_of_file(const std::string& path);

}  // namespace sleight::daemon
