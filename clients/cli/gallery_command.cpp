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
#include <filesystem>
#include <memory>
#include <mutex>
#include <string_view>
#include <system_error>
#include <utility>

#include <fmt/format.h>
#include <sys/stat.h>

#include "clients/gallery_server/answers.h"
#include "clients/gallery_server/gallery.h"
#include "clients/gallery_server/job_follower.h"
#include "clients/gallery_server/listed_files.h"
#include "clients/gallery_server/named_archives.h"
#include "clients/gallery_server/notes.h"
#include "clients/gallery_server/saved_gallery.h"
#include "clients/service_client/service_call.h"
#include "clients/terminal/interruption.h"
#include "clients/terminal/output.h"
#include "clients/terminal/progress_printer.h"
#include "clients/terminal/terminal.h"
#include "clients/web/keys.h"
#include "clients/web/server.h"
#include "common/base/descriptor.h"
#include "common/base/error.h"
#include "common/base/own_folder.h"
#include "common/base/version.h"
#include "common/json/value.h"
#include "common/rpc/client.h"

namespace sleight::cli {
namespace {

namespace fs = std::filesystem;

std::string folder_of_page(const char* name) {
  std::error_code failure;
  const fs::path program = fs::read_symlink("/proc/self/exe", failure);
  if (failure) {
    throw base::Error(
        fmt::format("/proc/self/exe: cannot find this program's folder: {}", failure.message()));
  }
  const fs::path folder = program.parent_path().parent_path() / "share" / "sleight" / name;
  if (!fs::exists(folder / "index.html", failure)) {
    throw base::Error(fmt::format(
        "{}: the gallery's page is missing. Building the page requires npm packages: run "
        "deploy/install-deps and build again (cmake without -DSLEIGHT_GALLERY=OFF)",
        folder.string()));
  }
  return folder.string();
}

/// Returns <folder of the running program>/../share/sleight/gallery. If the page is missing, throws
/// base::Error(environment) with instructions: building it requires npm packages.
std::string page_folder() {
  return folder_of_page("gallery");
}

/// The page for saved galleries: .../share/sleight/gallery-saved. Throws as page_folder().
std::string saved_page_folder() {
  return folder_of_page("gallery-saved");
}

bool is_secret(std::string_view text) {
  return text.size() == web::k_secret_digits &&
         text.find_first_not_of("0123456789abcdef") == std::string_view::npos;
}

/// Returns the file's secret, or "" if the file isn't ours or others can read it.
std::string secret_in(const fs::path& path) {
  const base::Descriptor file(::open(path.c_str(), O_RDONLY | O_NOFOLLOW | O_CLOEXEC));
  struct stat about {};
  if (file.get() < 0 || ::fstat(file.get(), &about) != 0) return {};
  const bool is_ours = S_ISREG(about.st_mode) && about.st_uid == ::geteuid() &&
                       (about.st_mode & (S_IRWXG | S_IRWXO)) == 0;
  if (!is_ours) return {};
  std::string text(web::k_secret_digits, '\0');
  if (::read(file.get(), text.data(), text.size()) != static_cast<ssize_t>(text.size())) return {};
  return is_secret(text) ? text : std::string();
}

/// The secret in $XDG_STATE_HOME/sleight/gallery/PORT.secret (default ~/.local/state/...), readable
/// only by its owner; created if missing. Empty if the secret cannot be stored; then the server
/// creates a new secret, and open pages need a new link.
std::string kept_secret(std::uint16_t port) {
  const auto folder = base::own_folder("XDG_STATE_HOME", ".local/state", "gallery");
  if (!folder) return {};
  const fs::path path = *folder / fmt::format("{}.secret", port);
  if (std::string kept = secret_in(path); !kept.empty()) return kept;
  std::error_code failure;
  fs::create_directories(*folder, failure);
  fs::remove(path, failure);
  const std::string secret = web::new_secret();
  const base::Descriptor file(::open(
      path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, S_IRUSR | S_IWUSR));
  const bool is_kept = file.get() >= 0 && ::write(file.get(), secret.data(), secret.size()) ==
                                              static_cast<ssize_t>(secret.size());
  return is_kept ? secret : std::string();
}

std::vector<gallery::SavedArchive> read_archives(const std::vector<std::string>& paths) {
  const gallery::ListedFiles listed = gallery::listed_files(paths);
  for (const gallery::ListedFiles::LeftOut& left : listed.left_out)
    fmt::print(stderr, "left out: {}: {}\n", left.name, left.reason);
  std::vector<gallery::SavedArchive> archives;
  std::vector<base::Error> faults;
  for (const auto& [path, name] : listed.files) {
    terminal::ProgressPrinter printer("reading " + path, stderr);
    const gallery::Snapshot::Options options{.progress = [&](std::uint64_t done, std::uint64_t of) {
      terminal::Interruption::check();
      printer.say(fmt::format("{} of {} animations", done, of));
    }};
    try {
      archives.push_back(
          {.name = name, .snapshot = std::make_shared<const gallery::Snapshot>(path, options)});
      printer.clear();
    } catch (const base::Error& error) {
      printer.clear();
      if (error.exit_code() == base::ExitCode::interrupted) throw;
      faults.push_back(error);
    }
  }
  // If no archive can be read, the first fault is thrown below and not printed here.
  const std::size_t thrown = archives.empty() && !faults.empty() ? 1 : 0;
  for (std::size_t i = thrown; i < faults.size(); ++i)
    fmt::print(stderr, "left out: {}\n", faults[i].what());
  if (thrown != 0) throw base::Error(faults.front());
  if (archives.empty()) {
    throw base::Error(base::ExitCode::usage,
                      "no archive (*.h5) found; subfolders are not searched");
  }
  return archives;
}

/// Fetches the archives of jobs. If a job has no archive, fetches its committed results.
void fetch_jobs(const gallery::NamedArchives& named) {
  for (const gallery::NamedArchives::Job& job : named.jobs()) {
    service_client::with_service(named.service(), [&](rpc::Client& client) {
      const terminal::Interruption interruption([&client] { client.interrupt(); });
      try {
        client.fetch_file({.job = job.id, .kind = rpc::FetchKind::archive}, job.path);
      } catch (const rpc::RefusedError&) {
        client.fetch_file({.job = job.id, .kind = rpc::FetchKind::so_far}, job.path);
      }
      if (terminal::Interruption::requested())
        throw base::Error(base::ExitCode::interrupted, "interrupted");
      return 0;
    });
  }
}

/// Saves archives, or the current archives of jobs. Prints progress and unreadable archives to
/// stderr. `service_called` returns the service's address. If no archive can be read, throws the
/// base::Error of the first archive. Also throws errors of save_gallery(). REQUIRES: options.save
/// is set; no other thread runs.
int save_archives(const CommandOptions& options, const std::function<std::string()>& service_called,
                  const analysis::Rules& rules) {
  return terminal::with_results([&] {
    const gallery::NamedArchives named(options.paths, service_called);
    fetch_jobs(named);
    const terminal::Interruption interruption;
    std::vector<gallery::SavedArchive> archives = read_archives(named.paths());
    terminal::ProgressPrinter printer("saving " + options.save, stderr);
    const gallery::SaveOptions save{.folder = options.save,
                                    .page = saved_page_folder(),
                                    .version = std::string(base::version()),
                                    .progress = [&](std::size_t done, std::size_t of) {
                                      terminal::Interruption::check();
                                      printer.say(fmt::format("{} of {} files", done, of));
                                    }};
    const auto save_readable = [&] {
      for (;;) {
        try {
          return save_gallery(archives, save, rules);
        } catch (const gallery::UnreadableArchive& error) {
          printer.clear();
          if (archives.size() == 1) throw;
          fmt::print(stderr, "left out: {}\n", error.what());
          archives.erase(archives.begin() + static_cast<std::ptrdiff_t>(error.number()));
        }
      }
    };
    const std::uint64_t bytes = save_readable();
    std::size_t animations = 0;
    for (const gallery::SavedArchive& archive : archives)
      animations += archive.snapshot->index().entries.size();
    printer.clear();
    constexpr double k_megabyte = 1e6;
    if (options.json) {
      const json::Value json{
          {"folder", options.save}, {"animations", animations}, {"bytes", bytes}};
      fmt::print("{}\n", json.dump(2));
    } else {
      fmt::print("{}: {} animations, {:.1f} MB; open {}, or publish the folder on any web server\n",
                 options.save, animations, static_cast<double>(bytes) / k_megabyte,
                 (std::filesystem::path(options.save) / "index.html").string());
    }
    return static_cast<int>(base::ExitCode::ok);
  });
}

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
  auto files = std::make_shared<const web::StaticFiles>(page_folder());

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
