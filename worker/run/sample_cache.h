// Holds the latest sample of each replica that a worker ran, so that the replica's next unit need
// not simulate this state again. A sample includes the simulation's outcome and any recording.
// Invariants
//   1. take() returns the sample that put() stored for the same replica and scan, or nothing.
//      Caching changes no result.
//   2. All samples together have at most bytes_max bytes. The oldest sample is evicted first. If a
//      sample is larger than bytes_max, it is not held.
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

/// Default memory of a worker's cache: enough for some hundred thousand samples of the world
/// `spelling`.
inline constexpr std::size_t k_cache_bytes_max = std::size_t{256} << 20U;

template <class Sample>
class SampleCache {
 public:
  explicit SampleCache(std::size_t bytes_max) { use_.bytes_max = bytes_max; }

  /// Removes and returns the sample before `next_scan`.
  std::optional<Sample> take(const plan::ReplicaKey& replica, std::uint64_t next_scan) {
    const std::scoped_lock lock(mutex_);
    const auto found = entries_.find(replica);
    if (found == entries_.end() || found->second.next_scan != next_scan) {
      ++use_.misses;
      return std::nullopt;
    }
    ++use_.hits;
    std::optional<Sample> sample(std::move(found->second.sample));
    forget(found);
    return sample;
  }

  bool holds(const plan::ReplicaKey& replica, std::uint64_t next_scan) const {
    const std::scoped_lock lock(mutex_);
    const auto found = entries_.find(replica);
    return found != entries_.end() && found->second.next_scan == next_scan;
  }

  /// `bytes`: size of the sample and everything that it owns.
  void put(const plan::ReplicaKey& replica, std::uint64_t next_scan, Sample sample,
           std::size_t bytes) {
    const std::scoped_lock lock(mutex_);
    const auto found = entries_.find(replica);
    if (found != entries_.end()) forget(found);
    const std::size_t whole = bytes + k_entry_bytes;
    if (whole > use_.bytes_max) return;
    while (use_.bytes + whole > use_.bytes_max) {
      forget(entries_.find(order_.front()));
      ++use_.evictions;
    }
    const auto place = order_.insert(order_.end(), replica);
    entries_.emplace(replica, Entry{next_scan, std::move(sample), whole, place});
    use_.bytes += whole;
  }

  plan::CacheUse use() const {
    const std::scoped_lock lock(mutex_);
    return use_;
  }

 private:
  struct Entry {
    std::uint64_t next_scan = 0;
    Sample sample;
    std::size_t bytes = 0;
    std::list<plan::ReplicaKey>::iterator place;
  };
  using Entries = std::map<plan::ReplicaKey, Entry>;
  /// Overhead of a sample: one node in each container.
  static constexpr std::size_t k_entry_bytes = sizeof(typename Entries::value_type) + 96;

  void forget(typename Entries::iterator entry) {
    use_.bytes -= entry->second.bytes;
    order_.erase(entry->second.place);
    entries_.erase(entry);
  }

  mutable std::mutex mutex_;
  Entries entries_;
  std::list<plan::ReplicaKey> order_;  ///< Oldest first.
  plan::CacheUse use_;
};

}  // namespace sleight::run
