#include "clients/cli/interruption.h"

#include "common/base/error.h"

namespace sleight::cli {
namespace {

constexpr std::array k_signals{SIGINT, SIGTERM};

volatile std::sig_atomic_t g_is_interrupted = 0;

void remember(int /*signal*/) {
  g_is_interrupted = 1;
}

}  // namespace

Interruption::Interruption() {
  g_is_interrupted = 0;
  struct sigaction action {};
  action.sa_handler = remember;
  // The second one finds the default.
  action.sa_flags = static_cast<int>(SA_RESETHAND);
  for (std::size_t i = 0; i < k_signals.size(); ++i)
    ::sigaction(k_signals.at(i), &action, &before_.at(i));
}

Interruption::~Interruption() {
  for (std::size_t i = 0; i < k_signals.size(); ++i)
    ::sigaction(k_signals.at(i), &before_.at(i), nullptr);
}

void Interruption::check() {
  if (g_is_interrupted != 0)
    throw base::Error(base::ExitCode::interrupted, "interrupted; what was not whole is taken away");
}

}  // namespace sleight::cli
