#include "clients/terminal/interruption.h"

#include <csignal>
#include <utility>

#include "common/base/check.h"
#include "common/base/error.h"

namespace sleight::terminal {
namespace {

constexpr std::array k_signals{SIGINT, SIGTERM};

// This variable is global, because a signal handler has no other access to it.
volatile std::sig_atomic_t g_is_interrupted = 0;
const std::function<void()>* g_also = nullptr;

void remember(int signal) {
  if (g_is_interrupted != 0) {
    // A second signal ends the process.
    std::signal(signal, SIG_DFL);
    std::raise(signal);
    return;
  }
  g_is_interrupted = 1;
  if (g_also != nullptr && *g_also) (*g_also)();
}

}  // namespace

Interruption::Interruption(std::function<void()> also) : also_(std::move(also)) {
  CHECK(g_also == nullptr);
  g_is_interrupted = 0;
  g_also = &also_;
  struct sigaction action {};
  action.sa_handler = remember;
  sigemptyset(&action.sa_mask);  // without SA_RESTART, a wait returns
  for (std::size_t i = 0; i < k_signals.size(); ++i)
    ::sigaction(k_signals.at(i), &action, &before_.at(i));
}

Interruption::~Interruption() {
  for (std::size_t i = 0; i < k_signals.size(); ++i)
    ::sigaction(k_signals.at(i), &before_.at(i), nullptr);
  g_also = nullptr;
}

bool Interruption::requested() {
  return g_is_interrupted != 0;
}

void Interruption::check() {
  if (requested())
    throw base::Error(base::ExitCode::interrupted, "interrupted; incomplete files were removed");
}

}  // namespace sleight::terminal
