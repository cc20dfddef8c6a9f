// Follows a job of the service, and keeps a local copy of its archive up to date.
//
// One thread watches the job's events. After each commit, another thread fetches the archive so
// far, which the service creates, and replaces the whole local file. Commits during a fetch are
// combined into the next fetch, so a slow service isn't overloaded. When the job has ended, its
// final archive is fetched. If the service is unreachable, the follower retries and reports this.
//
// Thread safety: `heard` is called from both threads, one call at a time.
#pragma once

#include <condition_variable>
#include <functional>
#include <mutex>
#include <string>
#include <thread>

#include "common/rpc/service.h"

namespace sleight::rpc {
class Client;
}

namespace sleight::gallery {

/// Status of the job for people, such as "running: 1,200 of 3,000 scans". `goes_on`: more may
/// follow.
using JobHeard = std::function<void(bool goes_on, const std::string& words)>;

class JobFollower {
 public:
  /// The archive is written to `path`. REQUIRES: the job exists.
  JobFollower(std::string socket, rpc::JobId job, std::string path, JobHeard heard);
  ~JobFollower();
  JobFollower(const JobFollower&) = delete;
  JobFollower& operator=(const JobFollower&) = delete;

 private:
  class Sink;

  void watch();
  void fetch_forever();
  /// Fetches one file; returns the error, or "" after success.
  std::string fetched(rpc::Client& client, rpc::FetchKind kind);
  void say(bool goes_on, const std::string& words);
  void set_news(bool has_ended);

  std::string socket_;
  rpc::JobId job_;
  std::string path_;
  JobHeard heard_;
  std::mutex saying_;

  std::mutex mutex_;  ///< guards all members below
  std::condition_variable changed_;
  bool has_news_ = true;  ///< initially true: fetch what was committed before the watch
  bool has_ended_ = false;
  bool is_over_ = false;
  rpc::Client* watching_ = nullptr;
  rpc::Client* fetching_ = nullptr;
  std::thread watcher_;
  std::thread fetcher_;
};

}  // namespace sleight::gallery
