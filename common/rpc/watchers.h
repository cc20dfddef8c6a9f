// Watch calls that wait for news.
//
// A watch call names several jobs. At first, the handler is queried for all of these jobs. Later,
// the handler is queried only for jobs that have news. The call is answered once, as soon as any of
// its jobs has news.
//
// Thread safety: everything happens on the loop's thread.
#pragma once

#include <kj/async.h>
#include <kj/timer.h>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "common/rpc/handler.h"

namespace sleight::rpc {

using Batches = std::vector<std::pair<JobId, base::Result<Batch, Refusal>>>;

class Watchers final : kj::TaskSet::ErrorHandler {
 public:
  Watchers(Handler& handler, kj::Timer& timer, double wait_s_max,
           std::function<void(const std::string&)> complain);
  ~Watchers();
  KJ_DISALLOW_COPY(Watchers);

  /// If there is no news within `wait_s_max`, the promise gives an empty list. Dropping the promise
  /// ends the wait. If the connection breaks, the promise is dropped in a later turn of the loop,
  /// perhaps after this object is destroyed.
  kj::Promise<Batches> wait(const Caller& caller, std::vector<WatchPoint> points);
  void news(JobId job);
  std::size_t waiting() const { return waiting_; }

 private:
  struct Waiter;
  struct Place {
    Waiter* waiter;
    std::size_t point;
  };

  Batches collect(const Caller& caller, const std::vector<WatchPoint>& points);
  void tell_due();
  void taskFailed(kj::Exception&& exception) override;

  Handler& handler_;
  kj::Timer& timer_;
  double wait_s_max_;
  std::function<void(const std::string&)> complain_;
  std::size_t waiting_ = 0;
  std::unordered_map<std::uint64_t, std::vector<Place>> by_job_;
  std::vector<Waiter*> due_;  ///< waiters with news
  /// Waiters' access to this object. The pointer is null after this object was destroyed.
  std::shared_ptr<Watchers*> self_ = std::make_shared<Watchers*>(this);
  kj::TaskSet tasks_;
};

}  // namespace sleight::rpc
