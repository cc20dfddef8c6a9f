#include "service/coordinator/stop_signal.h"

#include <atomic>
#include <csignal>

namespace sleight::coordinator {
namespace {

// A signal handler has no other way to reach the loop.
std::atomic<bool> requested{false};
static_assert(std::atomic<bool>::is_always_lock_free);

extern "C" void on_stop_signal(int) {
  requested.store(true);
}

}  // namespace

void catch_stop_signals() {
  for (const int number : {SIGINT, SIGTERM}) {
    struct sigaction action {};
    action.sa_handler = &on_stop_signal;
    // After the first one the default is back: a second Ctrl-C ends the process.
    action.sa_flags = static_cast<int>(SA_RESETHAND);
    sigaction(number, &action, nullptr);
  }
}

bool stop_requested() {
  return requested.load();
}

}  // namespace sleight::coordinator
