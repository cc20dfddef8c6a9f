#include "common/rpc/watchers.h"

#include <algorithm>
#include <exception>

#include "common/rpc/from_now.h"

namespace sleight::rpc {
namespace {

/// Maximum size of one answer. The next answer contains the remaining news.
constexpr std::size_t k_answer_bytes_max = 1U << 20U;

std::size_t bytes_in(const Batch& batch) {
  std::size_t bytes = 0;
  for (const StateChange& change : batch.changes)
    bytes += sizeof change + change.reason.size();
  return bytes + batch.events.size() * sizeof(events::RunEvent);
}

}  // namespace

struct Watchers::Waiter {
  Waiter(Watchers& watchers, const Caller& who, std::vector<WatchPoint> wanted,
         kj::Own<kj::PromiseFulfiller<Batches>> answer_to)
      : owner(watchers.self_), caller(who), points(std::move(wanted)), answer(kj::mv(answer_to)) {
    ++watchers.waiting_;
    for (std::size_t i = 0; i < points.size(); ++i)
      watchers.by_job_[points[i].job.value].push_back({this, i});
  }
  ~Waiter() {
    if (*owner == nullptr) return;
    Watchers& watchers = **owner;
    --watchers.waiting_;
    for (const WatchPoint& point : points) {
      const auto found = watchers.by_job_.find(point.job.value);
      std::erase_if(found->second, [this](const Place& place) { return place.waiter == this; });
      if (found->second.empty()) watchers.by_job_.erase(found);
    }
    std::erase(watchers.due_, this);
  }
  Waiter(const Waiter&) = delete;
  Waiter& operator=(const Waiter&) = delete;

  std::shared_ptr<Watchers*> owner;
  Caller caller;
  std::vector<WatchPoint> points;
  std::vector<std::size_t> fresh{};  ///< points whose jobs have news
  kj::Own<kj::PromiseFulfiller<Batches>> answer;
};

Watchers::Watchers(Handler& handler, kj::Timer& timer, double wait_s_max,
                   std::function<void(const std::string&)> complain)
    : handler_(handler),
      timer_(timer),
      wait_s_max_(wait_s_max),
      complain_(std::move(complain)),
      tasks_(*this) {}

Watchers::~Watchers() {
  *self_ = nullptr;
}

Batches Watchers::collect(const Caller& caller, const std::vector<WatchPoint>& points) {
  Batches batches;
  std::size_t events_left = k_batch_events_max;
  std::size_t bytes = 0;
  for (const WatchPoint& point : points) {
    if (events_left == 0 || bytes > k_answer_bytes_max) break;
    try {
      auto batch = handler_.events_after(caller, point, events_left);
      if (batch) {
        if (batch.value().empty()) continue;
        events_left -= std::min(events_left, batch.value().events.size());
        bytes += bytes_in(batch.value());
      }
      batches.emplace_back(point.job, std::move(batch));
    } catch (const std::exception& error) {
      complain_(error.what());
      batches.emplace_back(point.job, Refusal{.kind = RefusalKind::bug,
                                              .sentence = "The server can't read the job's events.",
                                              .what_to_do = "See the server's log."});
    }
  }
  return batches;
}

kj::Promise<Batches> Watchers::wait(const Caller& caller, std::vector<WatchPoint> points) {
  Batches now = collect(caller, points);
  if (!now.empty()) return now;
  auto later = kj::newPromiseAndFulfiller<Batches>();
  auto waiter = kj::heap<Waiter>(*this, caller, std::move(points), kj::mv(later.fulfiller));
  return later.promise
      .exclusiveJoin(timer_.atTime(from_now(wait_s_max_)).then([] { return Batches(); }))
      .attach(kj::mv(waiter));
}

void Watchers::news(JobId job) {
  const auto found = by_job_.find(job.value);
  if (found == by_job_.end()) return;
  const bool was_idle = due_.empty();
  for (const Place& place : found->second) {
    if (place.waiter->fresh.empty()) due_.push_back(place.waiter);
    auto& fresh = place.waiter->fresh;
    if (std::find(fresh.begin(), fresh.end(), place.point) == fresh.end())
      fresh.push_back(place.point);
  }
  // All news of one turn of the loop is delivered together.
  if (was_idle && !due_.empty()) tasks_.add(kj::evalLast([this] { tell_due(); }));
}

void Watchers::tell_due() {
  const std::vector<Waiter*> due = std::exchange(due_, {});
  for (Waiter* waiter : due) {
    std::vector<WatchPoint> fresh;
    for (const std::size_t point : std::exchange(waiter->fresh, {}))
      fresh.push_back(waiter->points[point]);
    Batches batches = collect(waiter->caller, fresh);
    // The waiter is destroyed with its promise, in a later turn. A second fulfill() has no effect.
    if (!batches.empty()) waiter->answer->fulfill(kj::mv(batches));
  }
}

void Watchers::taskFailed(kj::Exception&& exception) {
  complain_(exception.getDescription().cStr());
}

}  // namespace sleight::rpc
