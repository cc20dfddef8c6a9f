#include "clients/gallery_server/job_follower.h"

#include <chrono>
#include <utility>
#include <variant>

#include <fmt/format.h>

#include "clients/service_client/event_words.h"
#include "clients/service_client/known_servers.h"
#include "clients/service_client/service_call.h"
#include "clients/terminal/output.h"
#include "common/base/error.h"
#include "common/events/progress.h"
#include "common/rpc/client.h"

namespace sleight::gallery {
namespace {

/// Pause between a failed attempt and the next.
constexpr auto k_pause = std::chrono::milliseconds(500);
/// How long the service may be unreachable: practically without limit.
constexpr double k_away_s_max = 1e9;

}  // namespace

class JobFollower::Sink final : public rpc::WatchSink {
 public:
  explicit Sink(JobFollower& follower) : follower_(follower) {}

  bool changed(rpc::JobId, const rpc::StateChange& change) override {
    words_ = terminal::shown(service_client::words_of_change(change));
    follower_.say(true, words_);
    return true;
  }
  bool happened(const rpc::WatchedEvent& event) override {
    if (!event.event) return true;
    if (const auto* progress = std::get_if<events::Progress>(&event.event->what)) {
      const std::string name = fmt::format("job {} is running:", follower_.job_);
      words_ = terminal::shown(events::progress_line(name, *progress));
      follower_.say(true, words_);
    }
    follower_.set_news(false);
    return true;
  }
  bool settled(rpc::JobId) override {
    follower_.set_news(true);
    return true;
  }
  bool refused(rpc::JobId, const rpc::Refusal& refusal) override {
    follower_.say(false, terminal::shown_on_one_line(service_client::words_of(refusal)));
    follower_.set_news(true);
    return true;
  }
  bool lost(const std::string&) override {
    follower_.say(true,
                  "The service is unreachable. Loaded data stays visible, and the page "
                  "reconnects automatically.");
    return true;
  }
  bool found_again() override {
    follower_.say(true, words_);
    return true;
  }

 private:
  JobFollower& follower_;
  std::string words_;
};

JobFollower::JobFollower(std::string socket, rpc::JobId job, std::string path, JobHeard heard)
    : socket_(std::move(socket)), job_(job), path_(std::move(path)), heard_(std::move(heard)) {
  watcher_ = std::thread([this] { watch(); });
  fetcher_ = std::thread([this] { fetch_forever(); });
}

JobFollower::~JobFollower() {
  {
    const std::lock_guard lock(mutex_);
    is_over_ = true;
    changed_.notify_all();
    if (watching_ != nullptr) watching_->interrupt();
    if (fetching_ != nullptr) fetching_->interrupt();
  }
  watcher_.join();
  fetcher_.join();
}

void JobFollower::say(bool goes_on, const std::string& words) {
  const std::lock_guard lock(saying_);
  heard_(goes_on, words);
}

void JobFollower::set_news(bool has_ended) {
  const std::lock_guard lock(mutex_);
  has_news_ = true;
  has_ended_ = has_ended_ || has_ended;
  changed_.notify_all();
}

void JobFollower::watch() {
  rpc::Client client(service_client::place_of(socket_), {.away_s_max = k_away_s_max});
  {
    const std::lock_guard lock(mutex_);
    watching_ = &client;
  }
  Sink sink(*this);
  // If the first connection fails, retry as after a lost connection.
  while (true) {
    try {
      client.watch(job_, 1, sink);
      break;
    } catch (const std::exception& error) {
      say(true, terminal::shown_on_one_line(error.what()));
    }
    std::unique_lock lock(mutex_);
    if (changed_.wait_for(lock, k_pause, [this] { return is_over_; })) break;
  }
  const std::lock_guard lock(mutex_);
  watching_ = nullptr;
}

std::string JobFollower::fetched(rpc::Client& client, rpc::FetchKind kind) {
  try {
    client.fetch_file({.job = job_, .kind = kind}, path_);
    return {};
  } catch (const rpc::RefusedError& refused) {
    return service_client::words_of(refused.refusal());
  } catch (const base::Error& error) {
    return error.what();
  }
}

void JobFollower::fetch_forever() {
  rpc::Client client(service_client::place_of(socket_), {.away_s_max = k_away_s_max});
  {
    const std::lock_guard lock(mutex_);
    fetching_ = &client;
  }
  bool is_whole = false;
  while (!is_whole) {
    bool has_ended = false;
    {
      std::unique_lock lock(mutex_);
      changed_.wait(lock, [this] { return is_over_ || has_news_; });
      if (is_over_) break;
      has_news_ = false;
      has_ended = has_ended_;
    }
    // If a failed job has no archive, show its committed results.
    std::string fault =
        fetched(client, has_ended ? rpc::FetchKind::archive : rpc::FetchKind::so_far);
    if (has_ended && !fault.empty()) fault = fetched(client, rpc::FetchKind::so_far);
    if (has_ended) {
      is_whole = true;
      say(false, fault.empty() ? std::string() : terminal::shown_on_one_line(fault));
    } else if (!fault.empty()) {
      // Nothing is committed yet, or the service is unreachable (the watch reports which). Retry.
      std::unique_lock lock(mutex_);
      changed_.wait_for(lock, k_pause, [this] { return is_over_; });
    }
  }
  const std::lock_guard lock(mutex_);
  fetching_ = nullptr;
}

}  // namespace sleight::gallery
