#include "common/store/group_commit.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <future>
#include <stdexcept>
#include <string>

#include "tests/unit/common/store/examples.h"

namespace sleight::store {
namespace {

using std::chrono_literals::operator""ms;
using std::chrono_literals::operator""s;

/// A commit function that records its arguments. A test can pause the function or let it fail.
class Recorder {
 public:
  GroupCommit::Commit commit() {
    return [this](const GroupCommit::Group& group) {
      std::unique_lock lock(mutex_);
      ++calls_;
      changed_.notify_all();
      changed_.wait(lock, [&] { return open_; });
      if (calls_ == fail_at_) throw std::runtime_error("the disk is gone");
      for (const plan::UnitResult& result : group.results)
        first_scans_.push_back(result.unit.first_scan.value);
    };
  }

  void hold() { set(open_, false); }
  void release() { set(open_, true); }
  void fail_at(int call) { set(fail_at_, call); }
  void await_call(int call) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return calls_ >= call; });
  }
  int calls() {
    const std::scoped_lock lock(mutex_);
    return calls_;
  }
  std::vector<std::uint64_t> first_scans() {
    const std::scoped_lock lock(mutex_);
    return first_scans_;
  }

 private:
  template <class T>
  void set(T& field, T value) {
    const std::scoped_lock lock(mutex_);
    field = value;
    changed_.notify_all();
  }

  std::mutex mutex_;
  std::condition_variable changed_;
  bool open_ = true;
  int fail_at_ = 0;
  int calls_ = 0;
  std::vector<std::uint64_t> first_scans_;
};

plan::UnitResult small(std::uint64_t first_scan, std::uint32_t scans = 1) {
  return testing::result_of(0, first_scan, scans);
}

plan::UnitResult large(std::uint64_t first_scan, std::size_t bytes) {
  plan::UnitResult result = small(first_scan);
  result.state_after.resize(bytes);
  return result;
}

std::vector<std::uint64_t> numbers_to(std::uint64_t count) {
  std::vector<std::uint64_t> all;
  for (std::uint64_t i = 0; i < count; ++i)
    all.push_back(i);
  return all;
}

TEST(GroupCommit, KeepsOrderInFewCommits) {
  // Goal: results are committed in the order of the put() calls, and one commit may contain many
  // results. Method: put a thousand results, flush, and count the commits.
  Recorder recorder;
  GroupCommit group_commit(recorder.commit());
  for (std::uint64_t i = 0; i < 1000; ++i)
    group_commit.put(small(i));
  group_commit.flush();
  EXPECT_EQ(recorder.first_scans(), numbers_to(1000));
  EXPECT_LT(recorder.calls(), 500);
  EXPECT_EQ(group_commit.committed(), 1000U);
}

TEST(GroupCommit, CountsOnlyWhatIsCommitted) {
  // Goal: committed() counts a commit's scans only after the commit has returned. Method: call
  // committed() while a commit is paused, and again after the commit has returned.
  Recorder recorder;
  recorder.hold();
  GroupCommit group_commit(recorder.commit());
  group_commit.put(small(0, 7));
  recorder.await_call(1);
  EXPECT_EQ(group_commit.committed(), 0U);
  recorder.release();
  group_commit.flush();
  EXPECT_EQ(group_commit.committed(), 7U);
}

TEST(GroupCommit, CommitsWithoutBeingAsked) {
  // Goal: even without a flush, a small result is committed soon, and a large result at once.
  // Method: put a small result and wait for its commit. Then put a large result and wait. If a
  // commit never comes, the test exceeds its time limit.
  Recorder recorder;
  GroupCommit group_commit(recorder.commit());
  group_commit.put(small(0));
  recorder.await_call(1);
  group_commit.put(large(1, 2 * k_group_bytes));
  recorder.await_call(2);
}

TEST(GroupCommit, FlushOfNothingReturns) {
  // Goal: flush() returns at once if no result waits for a commit.
  Recorder recorder;
  GroupCommit group_commit(recorder.commit());
  group_commit.flush();
  group_commit.put(small(0));
  group_commit.flush();
  group_commit.flush();
  EXPECT_EQ(recorder.calls(), 1);
}

TEST(GroupCommit, FlushDoesNotWaitForLaterPuts) {
  // Goal: flush() returns once all results that were put before it are committed, even if other
  // callers continue to put results. Method: let every commit put another result, so the queue is
  // never empty.
  std::atomic<bool> stop{false};
  GroupCommit* self = nullptr;
  GroupCommit group_commit([&](const GroupCommit::Group& group) {
    if (!stop) self->put(small(group.results.back().unit.first_scan.value + 1));
  });
  self = &group_commit;
  group_commit.put(small(0));
  std::future<void> flushed = std::async(std::launch::async, [&] { group_commit.flush(); });
  EXPECT_EQ(flushed.wait_for(10s), std::future_status::ready);
  EXPECT_GE(group_commit.committed(), 1U);
  stop = true;
  flushed.get();
}

TEST(GroupCommit, FailureComesOutAndNothingFollows) {
  // Goal: once a commit has failed, nothing more is written, and every caller gets the error.
  // Method: let the second commit fail. Then all puts and flushes must throw.
  Recorder recorder;
  recorder.fail_at(2);
  GroupCommit group_commit(recorder.commit());
  group_commit.put(small(0, 3));
  group_commit.flush();
  group_commit.put(small(3));
  EXPECT_THROW(group_commit.flush(), std::runtime_error);
  for (int i = 0; i < 3; ++i) {
    EXPECT_THROW(group_commit.put(small(4)), std::runtime_error);
    EXPECT_THROW(group_commit.flush(), std::runtime_error);
  }
  EXPECT_EQ(recorder.calls(), 2);
  EXPECT_EQ(recorder.first_scans(), std::vector<std::uint64_t>{0});
  EXPECT_EQ(group_commit.committed(), 3U);
}

TEST(GroupCommit, FailureComesOutOfPutAlone) {
  // Goal: once a commit has failed, put() throws, so a caller gets the error even if it never calls
  // flush().
  Recorder recorder;
  recorder.fail_at(1);
  GroupCommit group_commit(recorder.commit());
  std::string reason;
  for (std::uint64_t i = 0; reason.empty(); ++i) {
    try {
      group_commit.put(small(i));
    } catch (const std::runtime_error& failure) {
      reason = failure.what();
    }
  }
  EXPECT_EQ(reason, "the disk is gone");
  EXPECT_EQ(group_commit.committed(), 0U);
}

/// Puts `count` large results in its own thread, and counts the results that put() has accepted.
class Putter {
 public:
  Putter(GroupCommit& group_commit, std::uint64_t count)
      : outcome_(std::async(std::launch::async, [this, &group_commit, count] {
          for (std::uint64_t i = 0; i < count; ++i) {
            group_commit.put(large(i, k_queue_bytes_max / 8));
            ++taken_;
          }
        })) {}

  /// Waits until put() accepts no more results. Returns the number of accepted results.
  std::uint64_t taken_when_stuck() const {
    std::uint64_t before = 0;
    do {
      before = taken_;
      std::this_thread::sleep_for(300ms);
    } while (before != taken_);
    return before;
  }
  bool stuck() const { return outcome_.wait_for(0ms) == std::future_status::timeout; }
  void finish() { outcome_.get(); }

 private:
  std::atomic<std::uint64_t> taken_{0};
  std::future<void> outcome_;  // declared last, because its thread uses the count
};

TEST(GroupCommit, StalledDiskHoldsPutsUp) {
  // Goal: while a group is being written, at most k_queue_bytes_max bytes of results wait in
  // memory, and no result is lost. Method: pause a commit, and put results. Each result has an
  // eighth of the limit's size. Check that put() accepts at least eight results and blocks until
  // the commit continues.
  Recorder recorder;
  recorder.hold();
  GroupCommit group_commit(recorder.commit());
  Putter putter(group_commit, 40);
  recorder.await_call(1);
  const std::uint64_t taken = putter.taken_when_stuck();
  EXPECT_TRUE(putter.stuck());
  EXPECT_GE(taken, 8U);
  EXPECT_LE(taken, 16U);
  recorder.release();
  putter.finish();
  group_commit.flush();
  EXPECT_EQ(recorder.first_scans(), numbers_to(40));
}

TEST(GroupCommit, FailureFreesWhoIsHeldUp) {
  // Goal: if put() waits for space in the queue and the commit fails, put() throws. Method: fill
  // the queue during a paused commit, then let the commit fail.
  Recorder recorder;
  recorder.hold();
  recorder.fail_at(1);
  GroupCommit group_commit(recorder.commit());
  Putter putter(group_commit, 40);
  recorder.await_call(1);
  (void)putter.taken_when_stuck();
  recorder.release();
  EXPECT_THROW(putter.finish(), std::runtime_error);
}

TEST(GroupCommit, DestructorCommits) {
  // Goal: the destructor commits all waiting results. If a commit has failed, the destructor
  // commits nothing. Method: destroy two objects without a flush. The first commit of the second
  // object fails.
  Recorder recorder;
  {
    GroupCommit group_commit(recorder.commit());
    for (std::uint64_t i = 0; i < 50; ++i)
      group_commit.put(small(i));
  }
  EXPECT_EQ(recorder.first_scans(), numbers_to(50));
  Recorder failing;
  failing.fail_at(1);
  {
    GroupCommit group_commit(failing.commit());
    group_commit.put(small(0));
  }
  EXPECT_EQ(failing.calls(), 1);
}

}  // namespace
}  // namespace sleight::store
