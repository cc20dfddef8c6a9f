// Goal: a watcher gets every numbered event once and in order, even if connections break and
// servers die. Method: use real servers and kill some of them.
#include <atomic>
#include <chrono>

#include "common/random/stream.h"
#include "common/rpc/client.h"
#include "tests/unit/common/rpc/fake_service.h"

namespace sleight::rpc {
namespace {

using testing::FakeService;
using testing::ServerProcess;
using testing::ServerThread;

class Listener final : public WatchSink {
 public:
  explicit Listener(std::uint64_t first = 1) : next_(first) {}

  bool changed(JobId, const StateChange& change) override {
    EXPECT_EQ(change, testing::change_of(++changes));
    return true;
  }
  bool happened(const WatchedEvent& event) override {
    EXPECT_TRUE(event.event.has_value());
    if (event.number == 0) {
      ++progress;
      return true;
    }
    EXPECT_EQ(event.number, next_++);
    EXPECT_EQ(event.line + "\n", events::to_line(testing::event_of(event.number)));
    last = event.number;
    if (pause_s > 0) std::this_thread::sleep_for(std::chrono::duration<double>(pause_s));
    return event.number != stop_at;
  }
  bool settled(JobId) override {
    ++ends;
    return true;
  }
  bool refused(JobId job, const Refusal& refusal) override {
    refusals.emplace_back(job.value, refusal.kind);
    return true;
  }
  bool lost(const std::string&) override {
    ++losses;
    return true;
  }
  bool found_again() override {
    ++returns;
    return true;
  }

  std::uint64_t changes = 0;
  std::uint64_t progress = 0;
  std::atomic<std::uint64_t> last = 0;
  std::uint64_t stop_at = 0;
  double pause_s = 0;
  int ends = 0;
  int losses = 0;
  int returns = 0;
  std::vector<std::pair<std::uint64_t, RefusalKind>> refusals;

 private:
  std::uint64_t next_;
};

class WatchTest : public testing::SocketFolder {
 protected:
  FakeService service;
};

TEST_F(WatchTest, TellsAllFromAnyNumberOnAndSettles) {
  // Goal: a watch may begin at any event number. The watch returns that event and each later event
  // once, in order, and then the job's end. Method: watch a finished job that has more events than
  // one answer can contain. Stop one watch early.
  service.jobs[1] = {.view = {.id = {1}}, .events = 1000, .changes = 3, .is_over = true};
  ServerThread server(socket(), service);
  Client client(socket());
  for (const std::uint64_t first : {1U, 2U, 500U, 1000U, 1001U}) {
    Listener listener(first);
    EXPECT_EQ(client.watch({1}, first, listener), Waited::settled);
    EXPECT_EQ(listener.last, first <= 1000 ? 1000U : 0U);
    EXPECT_EQ(listener.changes, 3U);
    EXPECT_EQ(listener.ends, 1);
  }
  Listener stops;
  stops.stop_at = 300;
  EXPECT_EQ(client.watch({1}, 1, stops), Waited::stopped);
  EXPECT_EQ(stops.last, 300U);
}

TEST_F(WatchTest, NewsArriveAsTheyCome) {
  // Goal: a watch receives each event at once, without polling, and can be interrupted. Method:
  // send events one by one, and count the calls of the handler.
  service.jobs[1] = {.view = {.id = {1}}};
  ServerThread server(socket(), service);
  Listener listener;
  Client* watching = nullptr;
  std::atomic<bool> is_ready = false;
  std::thread watcher([&] {
    Client client(socket());
    watching = &client;
    is_ready = true;
    EXPECT_EQ(client.watch({1}, 1, listener), Waited::interrupted);
    EXPECT_EQ(client.info().version, "1.2");  // the client still works
  });
  ASSERT_TRUE(testing::comes_true([&] { return server.counts().watchers == 1; }));
  for (std::uint64_t number = 1; number <= 20; ++number) {
    server.on_loop([&](Server& told) {
      service.jobs[1].events = number;
      told.news({1});
      told.news({1});
      told.news({2});
    });
    ASSERT_TRUE(testing::comes_true([&] { return listener.last == number; }));
  }
  ASSERT_TRUE(testing::comes_true([&] { return server.counts().watchers == 1; }));
  std::uint64_t asked = 0;
  server.on_loop([&](Server&) { asked = service.events_asked; });
  EXPECT_LE(asked, 2U + 2U * 20U);
  watching->interrupt();
  watcher.join();
  EXPECT_TRUE(testing::comes_true([&] { return server.counts().watchers == 0; }));
}

TEST_F(WatchTest, ASlowWatcherMissesNothingNumberedAndNothingQueues) {
  // Goal: a slow watcher gets all events but not all progress reports. The server buffers nothing
  // for the watcher. Method: send 20,000 progress reports and 2,000 events to a watcher that sleeps
  // after each event.
  const auto shared = testing::make_shared_memory();
  ServerProcess server(socket(), *shared);
  const std::size_t before = server.peak_bytes();
  std::atomic<bool> is_done = false;
  std::thread runs([&] {
    for (std::uint64_t n = 1; n <= 20'000; ++n) {
      shared->progress = n;
      shared->events = n / 10;
      if (n % 100 == 0) std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
    shared->is_over = true;
    is_done = true;
  });
  Client client(socket());
  Listener listener;
  listener.pause_s = 0.0002;
  EXPECT_EQ(client.watch({1}, 1, listener), Waited::settled);
  runs.join();
  EXPECT_EQ(listener.last, 2000U);
  EXPECT_GE(listener.progress, 1U);
  EXPECT_LT(listener.progress, 4000U);
  testing::expect_grown_less(server, before, std::size_t{8} << 20U);
}

TEST_F(WatchTest, NoneIsLostOrDoubledOverKilledServers) {
  // Goal: each numbered event and the job's end arrive once and in order, even if servers are
  // killed. Method: kill the server process at random moments while events are sent.
  random::Stream stream({.seed = 26, .purpose = random::Purpose::prior}, 0);
  const auto below = [&](std::uint64_t end) { return stream.bits() % end; };
  const auto shared = testing::make_shared_memory();
  auto server = std::make_unique<ServerProcess>(socket(), *shared);
  Listener listener;
  std::thread watcher([&] {
    Client client(socket(), {.first_wait_s = 0.002, .wait_s_max = 0.02});
    EXPECT_EQ(client.watch({1}, 1, listener), Waited::settled);
  });
  ASSERT_TRUE(testing::comes_true([&] {
    shared->events += 1;
    return listener.last > 3;
  }));
  for (int round = 0; round < 8; ++round) {
    for (std::uint64_t n = below(400); n > 0; --n) {
      shared->events += 1;
      if (n % 16 == 0) std::this_thread::sleep_for(std::chrono::microseconds(below(500)));
    }
    server->kill();
    shared->events += below(300);
    server = std::make_unique<ServerProcess>(socket(), *shared);
  }
  shared->is_over = true;
  watcher.join();
  EXPECT_EQ(listener.last, shared->events);
  EXPECT_EQ(listener.ends, 1);
  EXPECT_GE(listener.losses, 1);
  EXPECT_EQ(listener.losses, listener.returns);
}

TEST_F(WatchTest, GivesUpAServiceThatStaysAway) {
  // Goal: a watch gives up if the service stays away, and ends at once if there was never a
  // service. Method: watch without a service. Then kill the service during a watch. The client
  // waits only for a short time.
  const auto shared = testing::make_shared_memory();
  Listener listener;
  Client client(socket(), {.first_wait_s = 0.01, .wait_s_max = 0.05, .away_s_max = 0.3});
  EXPECT_THROW(client.watch({1}, 1, listener), NoServer);
  EXPECT_EQ(listener.losses, 0);
  auto server = std::make_unique<ServerProcess>(socket(), *shared);
  shared->events = 5;
  std::thread kills([&] {
    EXPECT_TRUE(testing::comes_true([&] { return listener.last == 5; }));
    server->kill();
  });
  EXPECT_THROW(client.watch({1}, 1, listener), NoServer);
  kills.join();
  EXPECT_EQ(listener.losses, 1);
}

TEST_F(WatchTest, WatchesManyJobsAtOnce) {
  // Goal: a watch of many jobs settles when each job has ended or was refused. Method: watch
  // finished jobs, a job that ends later, a missing job, and a job that is deleted during the
  // watch.
  for (std::uint64_t id = 1; id <= 50; ++id)
    service.jobs[id] = {.view = {.id = {id}}, .events = 0, .changes = 0, .is_over = id > 2};
  ServerThread server(socket(), service);
  std::thread ends([&] {
    ASSERT_TRUE(testing::comes_true([&] { return server.counts().watchers == 1; }));
    server.on_loop([&](Server& told) {
      service.jobs.erase(1);
      told.news({1});
    });
    ASSERT_TRUE(testing::comes_true([&] { return server.counts().watchers == 1; }));
    server.on_loop([&](Server& told) {
      service.jobs[2].is_over = true;
      told.news({2});
    });
  });
  Client client(socket());
  std::vector<WatchPoint> points;
  for (std::uint64_t id = 1; id <= 51; ++id)
    points.push_back({.job = {id}});
  Listener listener;
  EXPECT_EQ(client.watch(points, listener), Waited::settled);
  ends.join();
  EXPECT_EQ(listener.ends, 49);
  EXPECT_EQ(listener.refusals, (std::vector<std::pair<std::uint64_t, RefusalKind>>{
                                   {51, RefusalKind::not_found}, {1, RefusalKind::not_found}}));
}

TEST_F(WatchTest, ASilentServerIsHeardOfAndAGapIsSaid) {
  // Goal: if there is no news, a watch gets empty answers from time to time. If an event is
  // missing, the watch ends with a refusal. Method: use a short time limit. Let the handler skip an
  // event.
  service.jobs[1] = {.view = {.id = {1}}, .events = 3, .is_over = false};
  service.jobs[2] = {.view = {.id = {2}}, .events = 5, .is_over = true};
  service.gap_at = 4;
  ServerThread server(socket(), service, {.watch_s_max = 0.05});
  Client client(socket());
  Listener gap;
  EXPECT_EQ(client.watch({2}, 1, gap), Waited::settled);
  EXPECT_EQ(gap.last, 3U);
  EXPECT_EQ(gap.ends, 0);
  ASSERT_EQ(gap.refusals.size(), 1U);
  EXPECT_EQ(gap.refusals[0].second, RefusalKind::bug);

  std::thread ends([&] {
    EXPECT_TRUE(testing::comes_true([&] { return server.counts().calls >= 8; }));
    server.on_loop([&](Server& told) {
      service.jobs[1].is_over = true;
      told.news({1});
    });
  });
  Listener listener;
  EXPECT_EQ(client.watch({1}, 1, listener), Waited::settled);
  ends.join();
  EXPECT_EQ(listener.losses, 0);
  EXPECT_EQ(listener.last, 3U);
}

}  // namespace
}  // namespace sleight::rpc
