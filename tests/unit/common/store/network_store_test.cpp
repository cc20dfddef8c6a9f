// Goal: run stores work on a network disk, where processes can use neither shared memory nor flock.
// Method: simulate several nodes on one machine.
#include <fcntl.h>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <atomic>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <functional>
#include <optional>
#include <thread>
#include <vector>

#include "common/base/error.h"
#include "common/base/network_disk.h"
#include "common/store/lease_files.h"
#include "common/store/run_store.h"
#include "common/store/sessions.h"
#include "common/store/stored_run.h"
#include "tests/support/facts.h"
#include "tests/unit/common/store/examples.h"
#include "tests/unit/common/store/unshared_disk.h"

namespace sleight::store::network_store_test {

using ::testing::AllOf;
using testing::example_identity;
using ::testing::HasSubstr;
using testing::result_of;

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point begin) {
  return std::chrono::duration<double>(Clock::now() - begin).count();
}

/// Returns this process's identity, but on a machine of this name.
LeaseHolder on_node(const std::string& host) {
  LeaseHolder self = this_process();
  self.host = host;
  self.machine = host + "/its own kernel";
  return self;
}

std::optional<std::string> conflict_of(const std::function<void()>& act) {
  try {
    act();
    return std::nullopt;
  } catch (const base::Error& error) {
    EXPECT_EQ(error.exit_code(), base::ExitCode::conflict) << error.what();
    return error.what();
  }
}

class Child {
 public:
  explicit Child(const std::function<void()>& live) : process_(::fork()) {
    if (process_ != 0) return;
    int code = 0;
    try {
      live();
    } catch (const base::Error& error) {
      code = static_cast<int>(error.exit_code());
    }
    ::_exit(code);
  }
  ~Child() {
    if (!has_ended_) kill();
  }
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;

  void signal(int number) const { ::kill(process_, number); }
  void kill() {
    signal(SIGKILL);
    (void)end();
  }
  int wait(int options) {
    int status = 0;
    ::waitpid(process_, &status, options);
    has_ended_ = !WIFSTOPPED(status);
    return status;
  }
  int end() { return wait(0); }
  pid_t process() const { return process_; }

 private:
  pid_t process_;
  bool has_ended_ = false;
};

class Moment {
 public:
  Moment() { EXPECT_EQ(::pipe2(ends_, O_CLOEXEC), 0); }
  ~Moment() {
    ::close(ends_[0]);
    ::close(ends_[1]);
  }
  Moment(const Moment&) = delete;
  Moment& operator=(const Moment&) = delete;
  void comes(std::uint64_t number = 0) const {
    if (::write(ends_[1], &number, sizeof number) != sizeof number) ::_exit(99);
  }
  std::uint64_t await() const {
    std::uint64_t number = 0;
    EXPECT_EQ(::read(ends_[0], &number, sizeof number), static_cast<ssize_t>(sizeof number));
    return number;
  }
  std::uint64_t newest() const {
    ::fcntl(ends_[0], F_SETFL, O_NONBLOCK);
    std::uint64_t number = 0;
    while (::read(ends_[0], &number, sizeof number) == sizeof number) {
    }
    return number;
  }

 private:
  int ends_[2]{};
};

class NetworkStore : public testing::RunFolder {
 protected:
  std::vector<std::string> names_in_folder() const {
    std::vector<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator(folder()))
      names.push_back(entry.path().filename().string());
    return names;
  }
  testing::UnsharedDisk disk_;
};

TEST_F(NetworkStore, OneConnectionReadsAndWrites) {
  // Goal: while one thread commits results, other threads of the process can read all earlier
  // results. Shared memory isn't used. The next session resumes the run. Method: one thread reads a
  // hundred scans again and again. Another thread commits more scans.
  {
    RunLock lock(folder());
    RunStore store(folder(), example_identity(1), &lock);
    lock.keep();
    std::atomic<bool> stop = false;
    std::uint64_t times = 0;
    store.put(result_of(0, 0, 100));
    store.flush();
    std::thread reader([&] {
      const auto shared = store.to_read();
      for (; !stop || times == 0; ++times) {
        const StoredRun run(shared, {.chains = 1, .scans = 100});
        std::uint64_t next = 0;
        run.for_each_draw(base::ChainId{0}, [&](base::ScanIndex, const auto& record) {
          EXPECT_TRUE(testing::same_bits(record, testing::record_of(0, next++)));
        });
        EXPECT_EQ(next, 100U);
      }
    });
    for (std::uint64_t scan = 100; scan < 200; ++scan) {
      store.put(result_of(0, scan, 1));
      if (scan % 10 == 0) store.flush();
    }
    store.flush();
    stop = true;
    reader.join();
    EXPECT_GT(times, 0U);
    store.close({.end = events::End::finished});
  }
  RunLock lock(folder());
  RunStore store(folder(), example_identity(1), &lock);
  EXPECT_EQ(store.epoch(), 2U);
  EXPECT_EQ(store.progress().front().next_scan, 200U);
  EXPECT_THAT(names_in_folder(), ::testing::Not(::testing::Contains("store.sqlite-shm")));
  EXPECT_THAT(names_in_folder(), ::testing::Not(::testing::Contains("lock")));
}

TEST_F(NetworkStore, NeedsItsOwnMode) {
  // Goal: on the simulated network disk, SQLite's write-ahead log works only in the network-disk
  // mode. Method: open one database with SLEIGHT_NETWORK_DISK=0 and another database with
  // SLEIGHT_NETWORK_DISK=1.
  const auto mode = [&](const char* said, const std::string& name) {
    ::setenv(base::k_network_disk_variable, said, 1);
    Database database(path(name), Access::read_write);
    Statement journal = database.prepare("PRAGMA journal_mode");
    EXPECT_TRUE(journal.step());
    EXPECT_EQ(database.is_exclusive(), std::string(said) == "1");
    return journal.text(0);
  };
  EXPECT_EQ(mode("0", "local.sqlite"), "delete");
  EXPECT_EQ(mode("1", "network.sqlite"), "wal");
}

TEST_F(NetworkStore, OthersAreToldWhyTheyCantRead) {
  // Goal: while a process writes a run, only this process can read the run. Other readers get an
  // error that states the reason and the path of the latest archive. Once the writer has ended,
  // other readers can read the run. Method: while a store is open, call each function that reads a
  // run by its path.
  std::filesystem::create_directory(path("a.h5.run"));
  const std::string run = path("a.h5.run");
  {
    RunLock lock(run);
    RunStore store(run, example_identity(1), &lock);
    lock.keep();
    for (const auto& read : std::vector<std::function<void()>>{
             [&] { (void)sessions_of(run); }, [&] { (void)stored_request_of(run); },
             [&] { (void)StoredRun(run, {.chains = 1}); }, [&] { (void)open_to_read(run); }}) {
      std::filesystem::remove(path("a.h5"));
      const auto without = conflict_of(read);
      ASSERT_TRUE(without.has_value());
      EXPECT_THAT(*without, AllOf(HasSubstr("network disk"), HasSubstr("only the process"),
                                  HasSubstr(fmt::format("({})", ::getpid()))));
      EXPECT_THAT(*without, ::testing::Not(HasSubstr("latest archive")));
      put_bytes(path("a.h5"), "x");
      EXPECT_THAT(conflict_of(read).value_or(""), HasSubstr("latest archive, "));
    }
    store.close({.end = events::End::finished});
  }
  EXPECT_EQ(sessions_of(run).size(), 1U);
  EXPECT_EQ(stored_request_of(run).results_version, "r1");
}

TEST_F(NetworkStore, OfTwoNodesOneWrites) {
  // Goal: if a run is started on two nodes, one process writes. The other process gets an error
  // that names the writer's node, process and start time. Method: use leases of 5 s, so that the
  // second process sees a renewal.
  RunLock lock(folder(), {.lease_s = 5, .self = on_node("first")});
  RunStore store(folder(), example_identity(1), &lock);
  lock.keep();
  const auto conflict = conflict_of(
      [&] { const RunLock second(folder(), {.lease_s = 5, .self = on_node("second")}); });
  EXPECT_THAT(conflict.value_or(""),
              AllOf(HasSubstr(fmt::format("process ({}) on first, since 20", ::getpid())),
                    tests::HasFacts("wait|stop")));
  store.put(result_of(0, 0, 3));
  store.flush();
  testing::expect_stored_of(store, 0, 3);
}

TEST_F(NetworkStore, ADeadHolderOfThisNodeIsNoticedAtOnce) {
  // Goal: if a writer is killed, another process on the same machine can resume the run at once.
  // Method: kill a child that holds the lock. Take the lock and call owes_copies(). If the process
  // had waited until the lease ended, owes_copies() would be true.
  const Moment taken;
  Child holder([&] {
    RunLock lock(folder());
    taken.comes();
    ::pause();
  });
  (void)taken.await();
  EXPECT_THAT(conflict_of([&] { const RunLock lock(folder()); }).value_or(""),
              HasSubstr(fmt::format("({})", holder.process())));
  holder.kill();
  const RunLock lock(folder());
  EXPECT_FALSE(lock.owes_copies());
}

TEST_F(NetworkStore, ADeadHolderOfAnotherNodeLosesItsLease) {
  // Goal: if a holder on another node dies, its successor waits until the lease has ended. Then the
  // successor copies the committed results to its own files. If the successor is killed before
  // that, the next process copies them. Method: kill a child that acts as another node. Let a
  // second child take over, and kill this child at once.
  const Moment committed;
  Child holder([&] {
    RunLock lock(folder(), {.lease_s = 2, .self = on_node("first")});
    RunStore store(folder(), example_identity(1), &lock);
    lock.keep();
    store.put(result_of(0, 0, 20));
    store.flush();
    committed.comes();
    ::pause();
  });
  (void)committed.await();
  holder.kill();
  const auto begin = Clock::now();
  const Moment taken;
  Child heir([&] {
    const RunLock lock(folder());
    taken.comes();
    ::pause();
  });
  (void)taken.await();
  EXPECT_GT(seconds_since(begin), 1.5);
  heir.kill();

  RunLock lock(folder());
  EXPECT_TRUE(lock.owes_copies());
  RunStore store(folder(), example_identity(1), &lock);
  EXPECT_FALSE(lock.owes_copies());
  EXPECT_EQ(store.epoch(), 2U);
  testing::expect_stored_of(store, 0, 20);
}

/// Commits one scan at a time and reports committed() after each. SQLite's log has frequent
/// checkpoints. The process stops itself at a write.
void write_and_stand_still(const std::string& folder, testing::UnsharedDisk& disk,
                           std::uint64_t stop_after, const Moment& committed) {
  RunLock lock(folder, {.lease_s = 2.5, .self = on_node("sleeper")});
  RunStore store(folder, example_identity(1), &lock);
  lock.keep();
  store.to_read()->only_database().execute("PRAGMA wal_autocheckpoint=6");
  for (std::uint64_t scan = 0;; ++scan) {
    store.put(result_of(0, scan, 1));
    store.flush();
    committed.comes(store.committed());
    if (scan == 5) disk.stop_after(stop_after);
  }
}

TEST_F(NetworkStore, ASleeperChangesNothingAfterATakeover) {
  // Goal: a writer may pause for longer than its lease and wake up while its successor writes. The
  // writer then changes none of the successor's data, even if it paused within a commit. The writer
  // ends with a conflict, and the successor has everything that the writer reported. Method: stop
  // child processes at 12 different writes. Let a successor take over from each child. Wake the
  // child while the successor commits.
  constexpr std::uint64_t k_sleepers = 12;
  struct Sleeper {
    std::string folder{};
    Moment committed{};
    std::unique_ptr<Child> child{};
  };
  std::vector<Sleeper> sleepers(k_sleepers);
  for (std::uint64_t i = 0; i < k_sleepers; ++i) {
    Sleeper& one = sleepers[i];
    one.folder = path(fmt::format("run{}", i));
    one.child = std::make_unique<Child>(
        [&] { write_and_stand_still(one.folder, disk_, 3 * i, one.committed); });
  }
  for (Sleeper& one : sleepers)
    ASSERT_TRUE(WIFSTOPPED(one.child->wait(WUNTRACED)));

  std::vector<std::thread> heirs;
  heirs.reserve(sleepers.size());
  for (Sleeper& one : sleepers) {
    heirs.emplace_back([&one] {
      RunLock lock(one.folder, {.self = on_node("heir")});
      RunStore store(one.folder, example_identity(1), &lock);
      lock.keep();
      EXPECT_EQ(store.epoch(), 2U);
      const std::uint64_t begin = store.progress().front().next_scan;
      EXPECT_GE(begin, one.committed.newest());
      one.child->signal(SIGCONT);
      for (std::uint64_t scan = begin; scan < begin + 30; ++scan) {
        store.put(result_of(0, scan, 1));
        store.flush();
      }
      const int status = one.child->end();
      EXPECT_TRUE(WIFEXITED(status));
      EXPECT_EQ(WEXITSTATUS(status), static_cast<int>(base::ExitCode::conflict));
      EXPECT_GE(begin, one.committed.newest());
      testing::expect_stored_of(store, 0, begin + 30);
      Statement sound = store.to_read()->only_database().prepare("PRAGMA integrity_check");
      EXPECT_TRUE(sound.step());
      EXPECT_EQ(sound.text(0), "ok");
    });
  }
  for (std::thread& heir : heirs)
    heir.join();
  // A third session can open each store.
  for (const Sleeper& one : sleepers) {
    RunLock lock(one.folder, {.self = on_node("heir")});
    RunStore store(one.folder, example_identity(1), &lock);
    EXPECT_EQ(store.epoch(), 3U);
  }
}

TEST_F(NetworkStore, AFolderWithALeaseIsLockedByOne) {
  // Goal: even if a process treats a shared disk as local, it respects another process's lease.
  // Method: hold a lease, and try to take the lock as on a local disk. After the lease is released,
  // the local lock works again.
  {
    const RunLock lock(folder());
    ::setenv(base::k_network_disk_variable, "0", 1);
    EXPECT_THAT(conflict_of([&] { const RunLock second(folder()); }).value_or(""),
                HasSubstr(fmt::format("({})", ::getpid())));
  }
  const RunLock local(folder());
  EXPECT_THAT(names_in_folder(), ::testing::Contains("lock"));
}

TEST_F(NetworkStore, TurnsComeInOrder) {
  // Goal: a commit waits for at most one turn of each other thread, even if a reader takes turns
  // without a pause. Method: while one thread waits, count the turns of a greedy thread. The greedy
  // thread gets at most two turns. The first of these turns may have begun before the wait.
  SharedDatabase shared(path("a.sqlite"), Access::read_write);
  std::atomic<bool> stop = false;
  std::atomic<std::uint64_t> turns = 0;
  std::thread greedy([&] {
    while (!stop) {
      const SharedDatabase::Turn turn = shared.turn();
      ++turns;
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
  });
  while (turns == 0)
    std::this_thread::yield();
  for (int i = 0; i < 50; ++i) {
    const std::uint64_t before = turns;
    std::uint64_t after = 0;
    {
      const SharedDatabase::Turn turn = shared.turn();
      after = turns;
    }
    EXPECT_LE(after - before, 2U);
  }
  stop = true;
  greedy.join();
}

}  // namespace sleight::store::network_store_test
