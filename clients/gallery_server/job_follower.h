// Follows a job of the service, so that its archive is here and as new as what the job has
// committed.
//
// One thread watches the job's events; whenever something was committed another one fetches the
// archive so far, which the service makes, and puts it in its place as a whole. While a fetch goes
// on further news wait for the next one, so a slow service is asked no more than it can answer.
// When the job has ended its own archive is fetched. A service that is away is waited for, and
// said.
//
// Thread safety: `heard` is called from both threads, one call at a time.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <functional>
#include <mutex>
#include <string>
#include <thread>

#include "common/rpc/service.h"

namespace sleight::rpc {
class Client;
}

namespace sleight::gallery {

/// How the job stands, for people: "running: 1,200 of 3,000 scans". `goes_on`: more may come.
using JobHeard = std::function<void(bool goes_on, const std::string& words)>;

class JobFollower {
 public:
  /// The archive comes as `path`. REQUIRES: a job that there is.
  JobFollower(std::string socket, rpc::JobId job, std::string path, JobHeard heard);
  ~JobFollower();
  JobFollower(const JobFollower&) = delete;
  JobFollower& operator=(const JobFollower&) = delete;

 private:
  class Sink;

  void watch();
  void fetch_forever();
  /// One file; says why there is none.
  std::string fetched(rpc::Client& client, rpc::FetchKind kind);
  void say(bool goes_on, const std::string& words);
  void set_news(bool has_ended);

  std::string socket_;
  rpc::JobId job_;
  std::string path_;
  JobHeard heard_;
  std::mutex saying_;

  std::mutex mutex_;  ///< of all below
  std::condition_variable changed_;
  bool has_news_ = true;  ///< what was committed before the watch began
  bool has_ended_ = false;
  bool is_over_ = false;
  rpc::Client* watching_ = nullptr;
  rpc::Client* fetching_ = nullptr;
  std::thread watcher_;
  std::thread fetcher_;
};

}  // namespace sleight::gallery
