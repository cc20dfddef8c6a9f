#include "service/coordinator/stop_signal.h"

#include <atomic>
#include <csignal>
#include <cstdint>
#include <ctime>

namespace sleight::coordinator {
namespace {

// Global, because a signal handler has no other access to the loop.
std::atomic<bool> requested{false};
std::atomic<std::int64_t> requested_ns{0};
static_assert(std::atomic<bool>::is_always_lock_free);
static_assert(std::atomic<std::int64_t>::is_always_lock_free);

constexpr int k_stop_signals[] = {SIGINT, SIGTERM, SIGUSR1};

std::int64_t now_ns() {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return std::int64_t{now.tv_sec} * 1'000'000'000 + now.tv_nsec;
}

extern "C" void on_stop_signal(int number) {
  if (!requested.load()) {
    requested_ns.store(now_ns());
    requested.store(true);
    return;
  }
  if (now_ns() - requested_ns.load() < static_cast<std::int64_t>(k_echo_s * 1e9)) return;
  std::signal(number, SIG_DFL);
  std::raise(number);
}

}  // namespace

void catch_stop_signals() {
  for (const int number : k_stop_signals) {
    struct sigaction action {};
    action.sa_handler = &on_stop_signal;
    sigaction(number, &action, nullptr);
  }
}

void ignore_stop_signals() {
  for (const int number : k_stop_signals)
    std::signal(number, SIG_IGN);
}

bool stop_requested() {
  return requested.load();
}

}  // namespace sleight::coordinator
