// Speed of calls and events: only the transport, with a handler in memory.
//
// Without an option, 8 processes request a job's status, 100 watchers receive events, and a client
// fetches a file. The program prints calls/s, latencies and MB/s. With `--check`, a short run tests
// all answers, and doesn't judge times.
//
// The server and each client that requests a status are separate processes. Watchers are threads.
// An event's latency begins when the server's process can first see the event, and ends when the
// watcher's sink receives the event. The server looks for events every 0.5 ms.
#include <fmt/format.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "common/base/check.h"
#include "common/base/clock.h"
#include "common/rpc/client.h"
#include "tests/unit/common/rpc/fake_service.h"

namespace sleight::rpc {
namespace {

constexpr int k_clients = 8;
constexpr int k_watchers = 100;

struct Lengths {
  double status_s = 5;
  std::uint64_t events = 500;
  std::size_t file_bytes = 256U << 20U;
};

double at_share(std::vector<double>& sorted, double share) {
  const auto last = static_cast<double>(sorted.size() - 1);
  return sorted[static_cast<std::size_t>(share * last)];
}

void print_times(const std::string& what, std::vector<double> times_s) {
  std::sort(times_s.begin(), times_s.end());
  fmt::print("{}: median {:.2f} ms, p99 {:.2f} ms, longest {:.2f} ms\n", what,
             1e3 * at_share(times_s, 0.5), 1e3 * at_share(times_s, 0.99), 1e3 * times_s.back());
}

/// Runs a client process: makes calls for `seconds` seconds, and writes their latencies.
[[noreturn]] void ask_for_status(const std::string& socket, double seconds, int write_to) {
  Client client(socket);
  const base::SteadyClock clock;
  std::vector<double> times_s;
  const double end_s = clock.now_s() + seconds;
  for (double now_s = clock.now_s(); now_s < end_s;) {
    CHECK_EQ(client.status({1}).name, "one");
    const double done_s = clock.now_s();
    times_s.push_back(done_s - now_s);
    now_s = done_s;
  }
  const auto bytes = times_s.size() * sizeof(double);
  const auto* next = reinterpret_cast<const char*>(times_s.data());
  for (std::size_t done = 0; done < bytes;) {
    const auto wrote = ::write(write_to, next + done, bytes - done);
    CHECK_GT(wrote, 0);
    done += static_cast<std::size_t>(wrote);
  }
  ::_exit(0);
}

void measure_status(const std::string& socket, double seconds) {
  std::vector<int> ends;
  for (int i = 0; i < k_clients; ++i) {
    int pipe[2] = {};
    CHECK_EQ(::pipe(pipe), 0);
    if (::fork() == 0) ask_for_status(socket, seconds, pipe[1]);
    ::close(pipe[1]);
    ends.push_back(pipe[0]);
  }
  std::vector<double> times_s;
  for (const int end : ends) {
    double time_s = 0;
    while (::read(end, &time_s, sizeof time_s) == sizeof time_s)
      times_s.push_back(time_s);
    ::close(end);
  }
  for (int i = 0; i < k_clients; ++i) {
    int status = 0;
    CHECK_GT(::wait(&status), 0);
    CHECK_EQ(status, 0);
  }
  fmt::print("{} clients: {:.0f} status calls a second\n", k_clients,
             static_cast<double>(times_s.size()) / seconds);
  print_times("a status call", std::move(times_s));
}

class Stopwatch final : public WatchSink {
 public:
  Stopwatch(const std::vector<std::atomic<double>>& told_s, std::vector<double>& latencies_s)
      : told_s_(told_s), latencies_s_(latencies_s) {}
  bool changed(JobId, const StateChange&) override { return true; }
  bool happened(const WatchedEvent& event) override {
    if (event.number == 0) return true;
    CHECK_EQ(event.number, ++last_);
    latencies_s_.push_back(clock_.now_s() - told_s_[event.number]);
    return true;
  }
  bool refused(JobId, const Refusal& refusal) override {
    CHECK_EQ(refusal.sentence, "");
    return false;
  }

 private:
  const std::vector<std::atomic<double>>& told_s_;
  std::vector<double>& latencies_s_;
  base::SteadyClock clock_;
  std::uint64_t last_ = 0;
};

void measure_news(const std::string& socket, testing::Shared& shared, std::uint64_t events) {
  std::vector<std::atomic<double>> told_s(events + 1);
  std::vector<std::vector<double>> latencies_s(k_watchers);
  std::vector<std::thread> watchers;
  for (int i = 0; i < k_watchers; ++i) {
    watchers.emplace_back([&, i] {
      Stopwatch sink(told_s, latencies_s[static_cast<std::size_t>(i)]);
      CHECK(Client(socket).watch({1}, 1, sink) == Waited::settled);
    });
  }
  const base::SteadyClock clock;
  while (Client(socket).info().watchers < k_watchers)
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  for (std::uint64_t number = 1; number <= events; ++number) {
    told_s[number] = clock.now_s();
    shared.events = number;
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  shared.is_over = true;
  std::vector<double> all_s;
  for (int i = 0; i < k_watchers; ++i) {
    watchers[static_cast<std::size_t>(i)].join();
    const auto& own_s = latencies_s[static_cast<std::size_t>(i)];
    CHECK_EQ(own_s.size(), events);
    all_s.insert(all_s.end(), own_s.begin(), own_s.end());
  }
  print_times(fmt::format("an event, 50 a second, to {} watchers", k_watchers), std::move(all_s));
}

void measure_fetch(const std::string& socket, const std::string& path, std::size_t bytes) {
  const base::SteadyClock clock;
  const double began_s = clock.now_s();
  const FetchedFiles fetched = Client(socket).fetch_file({.job = {1}}, path);
  CHECK(fetched.how == Waited::settled);
  fmt::print("a file of {} MB, written and checked: {:.0f} MB a second\n", bytes >> 20U,
             static_cast<double>(bytes >> 20U) / (clock.now_s() - began_s));
}

int run(bool is_check) {
  const Lengths lengths =
      is_check ? Lengths{.status_s = 0.3, .events = 10, .file_bytes = 3U << 20U} : Lengths{};
  std::string form = (std::filesystem::temp_directory_path() / "sleight-rpc-XXXXXX").string();
  const std::string folder = ::mkdtemp(form.data());
  const std::string socket = folder + "/socket";
  {
    const auto shared = testing::make_shared_memory();
    const testing::ServerProcess server(socket, *shared, lengths.file_bytes);
    measure_status(socket, lengths.status_s);
    measure_news(socket, *shared, lengths.events);
    measure_fetch(socket, folder + "/ball.h5", lengths.file_bytes);
    fmt::print("the server had at most {} MB\n", server.peak_bytes() >> 20U);
  }
  std::filesystem::remove_all(folder);
  return EXIT_SUCCESS;
}

}  // namespace
}  // namespace sleight::rpc

int main(int argc, char** argv) {
  return sleight::rpc::run(argc > 1 && std::string_view(argv[1]) == "--check");
}
