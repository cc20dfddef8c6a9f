#include "clients/cli/gallery_command.h"

#include <fcntl.h>
#include <malloc.h>
#include <poll.h>
#include <signal.h>
#include <sys/signalfd.h>
#include <unistd.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <mutex>
#include <utility>

#include <fmt/format.h>

#include "clients/cli/save_command.h"
#include "clients/gallery_server/answers.h"
#include "clients/gallery_server/gallery.h"
#include "clients/gallery_server/job_follower.h"
#include "clients/gallery_server/named_archives.h"
#include "clients/gallery_server/notes.h"
#include "clients/gallery_server/nothing_to_show.h"
#include "clients/gallery_server/page_folder.h"
#include "clients/gallery_server/secret_file.h"
#include "clients/service_client/service_call.h"
#include "clients/terminal/terminal.h"
#include "clients/web/server.h"
#include "common/base/descriptor.h"
#include "common/base/error.h"
#include "common/base/version.h"
#include "common/json/value.h"

namespace sleight::cli {
namespace {

/// Sends new answers of /api/gallery to open pages, once a server exists. If nothing can be shown,
/// also warns on the terminal.
class Publisher {
 public:
  explicit Publisher(const std::vector<std::string>& paths) : paths_(paths) {}
  void begin(web::Server& server, const gallery::Answers& answers,
             const gallery::Gallery& gallery) {
    const std::lock_guard lock(mutex_);
    server_ = &server;
    answers_ = &answers;
    gallery_ = &gallery;
  }
  void end() {
    const std::lock_guard lock(mutex_);
    server_ = nullptr;
  }
  void publish() {
    const std::lock_guard lock(mutex_);
    if (server_ == nullptr) return;
    server_->publish("gallery", answers_->gallery_text());
    const std::string words = gallery::nothing_to_show(gallery_->state(), paths_);
    if (words != said_ && !words.empty()) terminal::complain("gallery: " + words);
    said_ = words;
  }

 private:
  const std::vector<std::string>& paths_;
  std::mutex mutex_;
  web::Server* server_ = nullptr;
  const gallery::Answers* answers_ = nullptr;
  const gallery::Gallery* gallery_ = nullptr;
  std::string said_{};  ///< last warning, not repeated
};

bool has_desktop() {
  const auto is_set = [](const char* name) {
    const char* value = std::getenv(name);
    return value != nullptr && *value != '\0';
  };
  return is_set("DISPLAY") || is_set("WAYLAND_DISPLAY");
}

/// Starts the desktop's opener in a separate process. Returns whether it started.
bool open_in_browser(const std::string& link) {
  const pid_t pid = ::fork();
  if (pid != 0) return pid > 0;
  // The child has its own session and no output, because browsers outlive terminals.
  ::setsid();
  const int nothing = ::open("/dev/null", O_RDWR);
  for (const int descriptor : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO})
    ::dup2(nothing, descriptor);
  sigset_t none;
  ::sigemptyset(&none);
  ::sigprocmask(SIG_SETMASK, &none, nullptr);
  ::execlp("xdg-open", "xdg-open", link.c_str(), nullptr);
  ::_exit(1);
}

std::string host_name() {
  std::array<char, 256> name{};
  if (::gethostname(name.data(), name.size() - 1) != 0) return "this-host";
  return name.data();
}

/// Tries the default port, then any port, because another gallery may have the default port.
std::unique_ptr<web::Server> served(const CommandOptions& options, web::ServerOptions how,
                                    const web::Server::Handler& handler) {
  const auto with_port = [&](std::uint16_t port) {
    web::ServerOptions chosen = how;
    chosen.port = port;
    chosen.secret = port == 0 ? std::string() : gallery::kept_secret(port);
    return std::make_unique<web::Server>(std::move(chosen), handler);
  };
  if (options.port != 0) return with_port(options.port);
  try {
    return with_port(k_usual_port);
  } catch (const base::Error& error) {
    if (error.exit_code() != base::ExitCode::conflict) throw;
    return with_port(0);
  }
}

void say_how_to_open(const web::Server& server, const CommandOptions& options,
                     const std::string& link, bool is_opened) {
  if (options.json) {
    const json::Value json{{"link", link}, {"port", server.port()}, {"pid", ::getpid()}};
    fmt::print("{}\n", json.dump());
  } else {
    fmt::print("{}{}\n", is_opened ? "opened in the browser: " : "open ", link);
    if (!is_opened) {
      fmt::print(
          "from another machine, run `ssh -L {0}:127.0.0.1:{0} {1}` and open the same link\n",
          server.port(), host_name());
    }
    fmt::print("The link works in one browser only{}. Ctrl-C ends the gallery.\n",
               terminal::is_typed() ? "; Enter prints another link" : "");
  }
  std::fflush(stdout);
}

/// Waits for Ctrl-C or SIGTERM. If a person presses Enter on the terminal, another link is printed.
void wait_for_end(web::Server& server, int signals) {
  const bool is_asked = terminal::is_typed();
  std::array<pollfd, 2> waited{
      {{.fd = signals, .events = POLLIN, .revents = 0},
       {.fd = is_asked ? STDIN_FILENO : -1, .events = POLLIN, .revents = 0}}};
  while (true) {
    if (::poll(waited.data(), waited.size(), -1) < 0) continue;
    if (waited[0].revents != 0) return;
    if (waited[1].revents == 0) continue;
    std::array<char, 256> typed{};
    if (::read(STDIN_FILENO, typed.data(), typed.size()) <= 0) {
      waited[1].fd = -1;
      continue;
    }
    fmt::print("{}\n", server.new_link());
    std::fflush(stdout);
  }
}

}  // namespace

int show_gallery(const CommandOptions& options, const std::function<std::string()>& service_called,
                 const analysis::Rules& rules) {
  if (!options.save.empty()) return save_archives(options, service_called, rules);
  // Threads that answer allocate and free whole indices. If each thread had its own heap, memory
  // would be wasted.
  ::mallopt(M_ARENA_MAX, 2);
  const gallery::NamedArchives shown(options.paths, service_called);
  auto files = std::make_shared<const web::StaticFiles>(gallery::page_folder());

  // Block signals before any thread starts, so that only the descriptor receives signals.
  sigset_t ends;
  ::sigemptyset(&ends);
  ::sigaddset(&ends, SIGINT);
  ::sigaddset(&ends, SIGTERM);
  ::sigaddset(&ends, SIGHUP);
  ::pthread_sigmask(SIG_BLOCK, &ends, nullptr);
  const base::Descriptor signals(::signalfd(-1, &ends, SFD_CLOEXEC));

  Publisher publisher(options.paths);
  gallery::Notes notes(gallery::notes_folder(shown.paths().front()));
  gallery::Gallery gallery({.paths = shown.paths(), .changed = [&] { publisher.publish(); }});
  const gallery::Answers answers(gallery, notes, rules, std::string(base::version()));
  const auto server = served(
      options,
      {.hosts = options.hosts,
       .files = files,
       .complain = [](const std::string& words) { fmt::print(stderr, "gallery: {}\n", words); }},
      answers);
  publisher.begin(*server, answers, gallery);
  publisher.publish();

  std::vector<std::unique_ptr<gallery::JobFollower>> followers;
  for (const gallery::NamedArchives::Job& job : shown.jobs()) {
    followers.push_back(std::make_unique<gallery::JobFollower>(
        shown.service(), job.id, job.path,
        [&gallery, path = job.path](bool goes_on, const std::string& words) {
          gallery.set_live(path, goes_on, words);
        }));
  }

  const std::string link = server->link();
  const bool is_opened = options.opens_browser && has_desktop() && open_in_browser(link);
  say_how_to_open(*server, options, link, is_opened);
  wait_for_end(*server, signals.get());
  followers.clear();
  publisher.end();
  server->stop();
  return static_cast<int>(base::ExitCode::ok);
}

}  // namespace sleight::cli
