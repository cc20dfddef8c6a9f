#include "clients/gallery_server/gallery_command.h"

#include <fcntl.h>
#include <malloc.h>
#include <poll.h>
#include <signal.h>
#include <sys/signalfd.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <system_error>
#include <utility>
#include <variant>
#include <vector>

#include <fmt/format.h>

#include "clients/cli/interruption.h"
#include "clients/cli/job_names.h"
#include "clients/cli/opened_archive.h"
#include "clients/cli/progress_printer.h"
#include "clients/cli/service_call.h"
#include "clients/gallery_server/answers.h"
#include "clients/gallery_server/gallery.h"
#include "clients/gallery_server/job_follower.h"
#include "clients/gallery_server/notes.h"
#include "clients/gallery_server/page_folder.h"
#include "clients/gallery_server/saved_gallery.h"
#include "clients/gallery_server/secret_file.h"
#include "clients/web/server.h"
#include "common/base/descriptor.h"
#include "common/base/error.h"
#include "common/base/version.h"
#include "common/rpc/client.h"

namespace sleight::gallery {
namespace {

namespace fs = std::filesystem;

/// Publishes what /api/gallery says, once there is a server.
class Publisher {
 public:
  void begin(web::Server& server, const Answers& answers) {
    const std::lock_guard lock(mutex_);
    server_ = &server;
    answers_ = &answers;
  }
  void end() {
    const std::lock_guard lock(mutex_);
    server_ = nullptr;
  }
  void publish() {
    const std::lock_guard lock(mutex_);
    if (server_ != nullptr) server_->publish("gallery", answers_->gallery_text());
  }

 private:
  std::mutex mutex_;
  web::Server* server_ = nullptr;
  const Answers* answers_ = nullptr;
};

bool has_desktop() {
  const auto is_set = [](const char* name) {
    const char* value = std::getenv(name);
    return value != nullptr && *value != '\0';
  };
  return is_set("DISPLAY") || is_set("WAYLAND_DISPLAY");
}

/// Whether the desktop's opener was started. Nothing of ours goes on in it.
bool open_in_browser(const std::string& link) {
  const pid_t pid = ::fork();
  if (pid != 0) return pid > 0;
  // A child of its own session, whose words go nowhere: browsers outlive terminals.
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

/// Tries the usual port, then any: a person who starts a second gallery wants a second gallery.
std::unique_ptr<web::Server> served(const CommandOptions& options, web::ServerOptions how,
                                    const web::Server::Handler& handler) {
  const auto with_port = [&](std::uint16_t port) {
    web::ServerOptions chosen = how;
    chosen.port = port;
    chosen.secret = port == 0 ? std::string() : kept_secret(port);
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
    const nlohmann::ordered_json json{{"link", link}, {"port", server.port()}, {"pid", ::getpid()}};
    fmt::print("{}\n", json.dump());
  } else {
    fmt::print("{}{}\n", is_opened ? "opened in the browser: " : "open ", link);
    if (!is_opened) {
      fmt::print("from another machine: ssh -L {0}:127.0.0.1:{0} {1}, then open the link there\n",
                 server.port(), host_name());
    }
    fmt::print("The link lets one browser in{}. Ctrl-C ends the gallery.\n",
               ::isatty(STDIN_FILENO) != 0 ? "; Enter makes another" : "");
  }
  std::fflush(stdout);
}

/// Waits for Ctrl-C or SIGTERM; Enter on a terminal makes another link.
void wait_for_end(web::Server& server, int signals) {
  const bool is_asked = ::isatty(STDIN_FILENO) != 0;
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

/// What the command line names: files, and jobs whose archives come as files.
struct Named {
  std::vector<std::string> paths{};
  struct Job {
    rpc::JobId id{};
    std::string path{};
  };
  std::vector<Job> jobs{};
};

/// A folder that goes with the gallery.
class OwnFolder {
 public:
  OwnFolder() {
    std::string form = (fs::temp_directory_path() / "sleight-gallery-XXXXXX").string();
    if (::mkdtemp(form.data()) == nullptr)
      throw base::Error(fmt::format("{}: can't make a folder there", form));
    path_ = form;
  }
  ~OwnFolder() {
    std::error_code failure;
    fs::remove_all(path_, failure);
  }
  OwnFolder(const OwnFolder&) = delete;
  OwnFolder& operator=(const OwnFolder&) = delete;
  const std::string& path() const { return path_; }

 private:
  std::string path_;
};

/// Names that are neither files nor jobs are a mistake of the command line; what is there and can't
/// be read is told on the page.
Named named(const std::vector<std::string>& texts, const std::string& socket,
            std::optional<OwnFolder>& folder) {
  Named named;
  for (const std::string& text : texts) {
    std::error_code failure;
    if (fs::exists(text, failure)) {
      named.paths.push_back(text);
      continue;
    }
    const auto names = cli::job_names_of(std::span(&text, 1));
    const auto* job = names ? std::get_if<rpc::JobId>(&names.value().front()) : nullptr;
    if (job == nullptr) {
      throw base::Error(base::ExitCode::usage,
                        fmt::format("{}: there is no such archive or folder", text));
    }
    // Asked here, so that a job that isn't there, and no service, are said at once.
    cli::with_service(socket, [&](rpc::Client& client) {
      client.status(*job);
      return 0;
    });
    if (!folder) folder.emplace();
    named.jobs.push_back(
        {.id = *job, .path = fmt::format("{}/job-{}.h5", folder->path(), job->value)});
    named.paths.push_back(named.jobs.back().path);
  }
  return named;
}

/// Archives and those in folders.
std::vector<std::string> files_of(const std::vector<std::string>& paths) {
  std::vector<std::string> files;
  for (const std::string& path : paths) {
    std::error_code failure;
    if (!fs::is_directory(path, failure)) {
      files.push_back(path);
      continue;
    }
    std::vector<std::string> inside;
    for (const auto& item : fs::directory_iterator(path, failure)) {
      if (item.path().extension() == ".h5") inside.push_back(item.path().string());
    }
    std::ranges::sort(inside);
    files.insert(files.end(), inside.begin(), inside.end());
  }
  return files;
}

int save(const CommandOptions& options, const cli::Rules& rules) {
  const cli::Interruption interruption;
  std::vector<SavedArchive> archives;
  std::size_t animations = 0;
  for (const std::string& path : files_of(options.paths)) {
    cli::ProgressPrinter printer("reading " + path, stderr);
    archives.push_back(
        {.name = fs::path(path).filename().string(),
         .snapshot = std::make_shared<const Snapshot>(
             path, Snapshot::Options{.progress = [&](std::uint64_t done, std::uint64_t of) {
               cli::Interruption::check();
               printer.say(fmt::format("{} of {} animations", done, of));
             }})});
    printer.clear();
    animations += archives.back().snapshot->index().entries.size();
  }
  cli::ProgressPrinter printer("saving " + options.save, stderr);
  const std::uint64_t bytes =
      save_gallery(archives,
                   {.folder = options.save,
                    .page = saved_page_folder(),
                    .version = std::string(base::version()),
                    .progress =
                        [&](std::size_t done, std::size_t of) {
                          cli::Interruption::check();
                          printer.say(fmt::format("{} of {} files", done, of));
                        }},
                   rules);
  printer.clear();
  constexpr double k_megabyte = 1e6;
  if (options.json) {
    const nlohmann::ordered_json json{
        {"folder", options.save}, {"animations", animations}, {"bytes", bytes}};
    fmt::print("{}\n", cli::dumped(json));
  } else {
    fmt::print(
        "{}: {} animations, {:.1f} MB; open {}/index.html, or put the folder on any web "
        "server\n",
        options.save, animations, static_cast<double>(bytes) / k_megabyte, options.save);
  }
  return static_cast<int>(base::ExitCode::ok);
}

}  // namespace

int show_gallery(const CommandOptions& options, const std::string& socket,
                 const cli::Rules& rules) {
  if (!options.save.empty()) return save(options, rules);
  // Threads that answer take and give back whole indexes: each would keep a heap of its own.
  ::mallopt(M_ARENA_MAX, 2);
  std::optional<OwnFolder> folder;
  const Named shown = named(options.paths, socket, folder);
  auto files = std::make_shared<const web::StaticFiles>(page_folder());

  // Before any thread begins, so that all have it: signals come to the descriptor alone.
  sigset_t ends;
  ::sigemptyset(&ends);
  ::sigaddset(&ends, SIGINT);
  ::sigaddset(&ends, SIGTERM);
  ::sigaddset(&ends, SIGHUP);
  ::pthread_sigmask(SIG_BLOCK, &ends, nullptr);
  const base::Descriptor signals(::signalfd(-1, &ends, SFD_CLOEXEC));

  Publisher publisher;
  Notes notes(notes_folder(shown.paths.front()));
  Gallery gallery({.paths = shown.paths, .changed = [&] { publisher.publish(); }});
  const Answers answers(gallery, notes, rules, std::string(base::version()));
  const auto server = served(
      options,
      {.hosts = options.hosts,
       .files = files,
       .complain = [](const std::string& words) { fmt::print(stderr, "gallery: {}\n", words); }},
      answers);
  publisher.begin(*server, answers);
  publisher.publish();

  std::vector<std::unique_ptr<JobFollower>> followers;
  for (const Named::Job& job : shown.jobs) {
    followers.push_back(std::make_unique<JobFollower>(
        socket, job.id, job.path,
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

}  // namespace sleight::gallery
