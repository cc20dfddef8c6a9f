#include "clients/cli/service_call.h"

#include <fmt/format.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <csignal>
#include <cstdint>
#include <cstdio>

#include "clients/cli/known_servers.h"
#include "common/base/check.h"
#include "common/request/text.h"

namespace sleight::cli {
namespace {

// A handler has no arguments of ours, so what it needs stands here.
std::atomic<rpc::Client*> interrupted_client = nullptr;
volatile std::sig_atomic_t was_interrupted = 0;
bool is_catching = false;

extern "C" void on_interrupt(int signal) {
  if (was_interrupted != 0) {
    // The second one: people mean it.
    std::signal(signal, SIG_DFL);
    std::raise(signal);
    return;
  }
  was_interrupted = 1;
  if (rpc::Client* client = interrupted_client.load()) client->interrupt();
}

void set_handlers(void (*handler)(int)) {
  struct sigaction action {};
  action.sa_handler = handler;
  sigemptyset(&action.sa_mask);  // without SA_RESTART: a wait returns
  for (const int signal : {SIGINT, SIGTERM})
    ::sigaction(signal, &action, nullptr);
}

}  // namespace

base::ExitCode exit_code_of(rpc::RefusalKind kind) {
  switch (kind) {
    case rpc::RefusalKind::not_allowed:
      return base::ExitCode::not_allowed;
    case rpc::RefusalKind::bad_request:
      return base::ExitCode::bad_request;
    case rpc::RefusalKind::conflict:
      return base::ExitCode::conflict;
    case rpc::RefusalKind::not_found:
    case rpc::RefusalKind::gone:
      return base::ExitCode::usage;
    case rpc::RefusalKind::bug:
      return base::ExitCode::bug;
    case rpc::RefusalKind::unknown:
    case rpc::RefusalKind::limit:
    case rpc::RefusalKind::busy:
    case rpc::RefusalKind::environment:
      return base::ExitCode::environment;
  }
  return base::ExitCode::environment;
}

std::string words_of(const rpc::Refusal& refusal) {
  std::string words = shown(refusal.sentence);
  if (!refusal.what_to_do.empty()) words += fmt::format(" {}", shown(refusal.what_to_do));
  return words;
}

std::string shown_on_one_line(std::string text) {
  while (!text.empty() && text.back() == '\n')
    text.pop_back();
  std::ranges::replace(text, '\n', ' ');
  return shown(text);
}

std::string shown(std::string_view text) {
  constexpr std::size_t k_characters_max = 1000;  // longer sentences of the service are cut
  return request::printable(text, k_characters_max);
}

void complain(const std::string& line) {
  std::fputs((line + "\n").c_str(), stderr);
}

int with_service(const std::string& called, const std::function<int(rpc::Client&)>& work) {
  rpc::Client client(place_of(called));
  try {
    return work(client);
  } catch (const rpc::NoServer& error) {
    throw base::Error(base::ExitCode::no_server, shown(error.what()));
  } catch (const rpc::RefusedError& error) {
    const rpc::Refusal& refusal = error.refusal();
    throw base::Error(exit_code_of(refusal.kind), words_of(refusal));
  }
}

EndsWithItsReader::EndsWithItsReader() : over_(::eventfd(0, EFD_CLOEXEC)) {
  if (over_ < 0) return;
  look_ = std::thread([over = over_] {
    // Signals are the main thread's.
    sigset_t all;
    sigfillset(&all);
    ::pthread_sigmask(SIG_BLOCK, &all, nullptr);
    while (true) {
      pollfd looks[2] = {{.fd = STDOUT_FILENO, .events = 0, .revents = 0},
                         {.fd = over, .events = POLLIN, .revents = 0}};
      if (::poll(looks, 2, -1) < 0) continue;
      if (looks[1].revents != 0) return;
      // A terminal that is gone says so by SIGHUP.
      if ((looks[0].revents & POLLERR) == 0) return;
      std::signal(SIGPIPE, SIG_DFL);
      ::kill(::getpid(), SIGPIPE);
      return;
    }
  });
}

EndsWithItsReader::~EndsWithItsReader() {
  if (over_ < 0) return;
  const std::uint64_t one = 1;
  static_cast<void>(!::write(over_, &one, sizeof one));
  look_.join();
  ::close(over_);
}

Interrupts::Interrupts(rpc::Client* client) {
  CHECK(!is_catching);
  is_catching = true;
  was_interrupted = 0;
  interrupted_client = client;
  set_handlers(&on_interrupt);
}

Interrupts::~Interrupts() {
  set_handlers(SIG_DFL);
  interrupted_client = nullptr;
  is_catching = false;
}

bool Interrupts::requested() {
  return was_interrupted != 0;
}

}  // namespace sleight::cli
