// The newest samples of the replicas that a worker ran last, so that the next unit of a replica
// need not simulate its state again.
//
// Invariant: what is taken is what was put for that replica and scan, or nothing; so whether
// anything is cached changes no result.
// Thread-safe.
#pragma once

#include <cstddef>
#include <cstdint>
#include <list>
#include <map>
#include <mutex>
#include <optional>
#include <utility>

#include "common/plan/unit.h"

namespace sleight::run {

template <class Sample>
class SampleCache {
 public:
  /// Holds so many replicas at most: least recently put first out.
  explicit SampleCache(std::size_t replicas_max) : replicas_max_(replicas_max) {}

  /// The sample before a scan, which is then no longer held.
  std::optional<Sample> take(const plan::ReplicaKey& replica, std::uint64_t next_scan) {
    const std::scoped_lock lock(mutex_);
    const auto found = entries_.find(replica);
    if (found == entries_.end() || found->second.next_scan != next_scan) return std::nullopt;
    std::optional<Sample> sample(std::move(found->second.sample));
    order_.erase(found->second.place);
    entries_.erase(found);
    return sample;
  }

  void put(const plan::ReplicaKey& replica, std::uint64_t next_scan, Sample sample) {
    const std::scoped_lock lock(mutex_);
    const auto found = entries_.find(replica);
    if (found != entries_.end()) {
      order_.erase(found->second.place);
      entries_.erase(found);
    }
    while (entries_.size() >= replicas_max_ && !order_.empty()) {
      entries_.erase(order_.front());
      order_.pop_front();
    }
    const auto place = order_.insert(order_.end(), replica);
    entries_.emplace(replica, Entry{next_scan, std::move(sample), place});
  }

 private:
  struct Entry {
    std::uint64_t next_scan = 0;
    Sample sample;
    std::list<plan::ReplicaKey>::iterator place;
  };
  std::size_t replicas_max_;
  std::mutex mutex_;
  std::map<plan::ReplicaKey, Entry> entries_;
  std::list<plan::ReplicaKey> order_;  ///< oldest first
};

}  // namespace sleight::run
