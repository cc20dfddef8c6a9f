// Calls per second that a daemon answers: durable submits, and status requests while there are many
// jobs.
//
// Usage: `sleight-service-bench SOCKET SUBMITS SECONDS`.
//
// Eight processes together submit SUBMITS jobs. After each submit, the process waits until the job
// is durable. Then the processes request the status of random jobs for SECONDS. The daemon must be
// running (service_figures.py).
#include <fmt/format.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <functional>
#include <string>
#include <vector>

#include "common/base/check.h"
#include "common/base/clock.h"
#include "common/rpc/client.h"

namespace sleight::rpc {
namespace {

constexpr int k_clients = 8;
constexpr const char* k_request =
    "[world]\nname = \"ball_2d\"\n[sampler]\nmethod = \"metropolis_hastings\"\n[stop]\nscans = "
    "100\n";

using Times = std::vector<double>;

/// Collects the call times of each of k_clients processes.
Times in_processes(const std::function<Times(int client)>& calls) {
  std::vector<int> from;
  for (int client = 0; client < k_clients; ++client) {
    int ends[2];
    CHECK_EQ(pipe(ends), 0);
    if (fork() == 0) {
      const Times times = calls(client);
      const char* bytes = reinterpret_cast<const char*>(times.data());
      std::size_t left = times.size() * sizeof(double);
      while (left > 0) {
        const ssize_t count = write(ends[1], bytes, left);
        CHECK_GT(count, 0);
        bytes += count;
        left -= static_cast<std::size_t>(count);
      }
      _exit(0);
    }
    close(ends[1]);
    from.push_back(ends[0]);
  }
  Times all;
  for (const int end : from) {
    double time = 0;
    std::string bytes;
    char piece[4096];
    for (ssize_t count = 0; (count = read(end, piece, sizeof piece)) > 0;)
      bytes.append(piece, static_cast<std::size_t>(count));
    for (std::size_t at = 0; at + sizeof time <= bytes.size(); at += sizeof time) {
      std::copy_n(bytes.data() + at, sizeof time, reinterpret_cast<char*>(&time));
      all.push_back(time);
    }
    close(end);
  }
  while (wait(nullptr) > 0) {
  }
  return all;
}

void print(const char* what, Times times, double seconds) {
  std::sort(times.begin(), times.end());
  const auto at = [&](double share) {
    return 1e3 * times[static_cast<std::size_t>(share * static_cast<double>(times.size() - 1))];
  };
  fmt::print("{}: {:.0f} a second; median {:.2f} ms, p99 {:.2f} ms, longest {:.2f} ms\n", what,
             static_cast<double>(times.size()) / seconds, at(0.5), at(0.99), at(1));
}

int run(const std::string& socket, std::uint64_t submits, double seconds) {
  const base::SteadyClock clock;
  const double begin_s = clock.now_s();
  const Times submitted = in_processes([&](int) {
    Client client(socket);
    Times times;
    for (std::uint64_t i = 0; i < submits / k_clients; ++i) {
      const double before_s = clock.now_s();
      client.submit({.key = random_key(), .jobs = {{.name = "bench", .request = k_request}}});
      times.push_back(clock.now_s() - before_s);
    }
    return times;
  });
  print("durable submits", submitted, clock.now_s() - begin_s);
  const std::uint64_t jobs = Client(socket).list({.count = 1}).total;
  fmt::print("jobs: {}\n", jobs);
  const Times asked = in_processes([&](int number) {
    Client client(socket);
    Times times;
    std::uint64_t job = static_cast<std::uint64_t>(number) * 977;
    for (const double end_s = clock.now_s() + seconds; clock.now_s() < end_s;) {
      job = (job * 6364136223846793005U + 1442695040888963407U);
      const double before_s = clock.now_s();
      const JobView view = client.status(JobId{1 + (job >> 33U) % jobs});
      CHECK_EQ(view.name, "bench");
      times.push_back(clock.now_s() - before_s);
    }
    return times;
  });
  print("status", asked, seconds);
  return 0;
}

}  // namespace
}  // namespace sleight::rpc

int main(int argc, char** argv) {
  if (argc != 4) {
    fmt::print(stderr, "usage: sleight-service-bench SOCKET SUBMITS SECONDS\n");
    return 2;
  }
  return sleight::rpc::run(argv[1], std::strtoull(argv[2], nullptr, 10),
                           std::strtod(argv[3], nullptr));
}
