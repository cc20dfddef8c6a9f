#include "service/keeper/keep.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/signalfd.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <limits>
#include <optional>
#include <system_error>
#include <utility>

#include "common/base/check.h"
#include "common/base/clock.h"
#include "common/base/descriptor.h"
#include "common/base/file_system.h"
#include "common/base/network_disk.h"
#include "common/store/sessions.h"
#include "service/keeper/attempt_record.h"
#include "service/keeper/bounded_log.h"
#include "service/keeper/command.h"
#include "service/keeper/keeper_lock.h"
#include "service/keeper/process_table.h"
#include "service/keeper/program.h"

namespace sleight::keeper {
namespace {

constexpr double k_never_s = std::numeric_limits<double>::infinity();
/// Maximum time to wait for a signal, output or a message. The wait is shorter if a check is due
/// earlier.
constexpr double k_patience_s_max = 3600;
/// Interval at which the keeper checks whether mpirun has ranks.
constexpr double k_rank_look_s = 1;
/// Interval at which the keeper checks whether mpirun has its first rank. The interval is short,
/// because ranks may be short-lived and a stop may wait for them.
constexpr double k_first_rank_look_s = 0.02;
/// Remaining descendants are killed again at growing intervals. These are the first and the last
/// interval.
constexpr int k_kill_again_ms_min = 1;
constexpr int k_kill_again_ms_max = 100;
/// Interval at which a waiting keeper checks another keeper.
constexpr int k_other_look_ms = 200;
/// Maximum length of unparsed text from the pipe. This maximum is longer than any line.
constexpr std::size_t k_told_bytes_max = 4 * events::k_end_line_bytes_max;

double unix_now_s() {
  return std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count();
}

[[noreturn]] void fail(const std::string& what) {
  throw base::Error(fmt::format("{}: {}", what, std::strerror(errno)));
}

double seconds_of(const timeval& time) {
  return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
}

std::string run_folder_of(const std::string& folder) {
  return fmt::format("{}/{}.run", folder, k_output_name);
}

/// Returns the run's sessions. If there is no store, returns none. If the store can't be read, logs
/// this and returns none.
std::vector<store::Session> sessions_in(const std::string& folder, BoundedLog& log) {
  if (!base::PosixFileSystem().exists(run_folder_of(folder) + "/store.sqlite")) return {};
  try {
    return store::sessions_of(run_folder_of(folder));
  } catch (const base::Error& error) {
    log.mark(fmt::format("keeper: can't read how the run's sessions ended: {}", error.what()));
    return {};
  }
}

/// The pipe on which a program reports its session's end. The keeper holds both ends. Otherwise it
/// would read an end of file before the first writer opens the pipe.
class EndPipe {
 public:
  explicit EndPipe(const std::string& path) {
    // Create a new pipe. No process of an earlier attempt then has it open.
    if (::unlink(path.c_str()) != 0 && errno != ENOENT) fail(path);
    if (::mkfifo(path.c_str(), 0600) != 0) fail(path);
    reader_.reset(::open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC));
    if (!reader_) fail(path);
    writer_.reset(::open(path.c_str(), O_WRONLY | O_NONBLOCK | O_CLOEXEC));
    if (!writer_) fail(path);
  }

  int descriptor() const { return reader_.get(); }
  /// The first reported end.
  const std::optional<events::RunEnd>& told() const { return told_; }

  void take() {
    std::array<char, events::k_end_line_bytes_max> piece{};
    ssize_t count = 0;
    while ((count = ::read(reader_.get(), piece.data(), piece.size())) > 0) {
      text_.append(piece.data(), static_cast<std::size_t>(count));
      std::size_t end = 0;
      while ((end = text_.find('\n')) != std::string::npos) {
        if (!told_) told_ = events::run_end_of(std::string_view(text_).substr(0, end));
        text_.erase(0, end + 1);
      }
      if (text_.size() > k_told_bytes_max) text_.clear();
    }
  }

 private:
  base::Descriptor reader_;
  base::Descriptor writer_;
  std::string text_{};
  std::optional<events::RunEnd> told_{};
};

/// Copies the program's output from its pipe to the log.
class Output {
 public:
  explicit Output(BoundedLog& log) : log_(log) {
    int ends[2];
    if (::pipe2(ends, O_CLOEXEC) != 0) fail("can't create a pipe");
    reader_.reset(ends[0]);
    writer_.reset(ends[1]);
    ::fcntl(reader_.get(), F_SETFL, O_NONBLOCK);
  }

  /// Once all writers have closed the pipe, returns a negative number, which poll ignores.
  int descriptor() const { return reader_.get(); }
  int writer() const { return writer_.get(); }
  void close_writer() { writer_.reset(); }
  std::vector<std::string> last_lines() const { return last_.lines(); }

  /// Reads the available output, but at most `pieces` pieces, so that signals are handled in
  /// between.
  void take(int pieces) {
    for (; pieces > 0; --pieces) {
      const ssize_t count = ::read(reader_.get(), piece_.data(), piece_.size());
      if (count < 0) return;
      if (count == 0) {
        reader_.reset();
        return;
      }
      const std::string_view bytes(piece_.data(), static_cast<std::size_t>(count));
      last_.append(bytes);
      log_.append(bytes);
    }
  }

 private:
  BoundedLog& log_;
  base::Descriptor reader_;
  base::Descriptor writer_;
  LastLines last_{k_tail_lines_max};
  std::array<char, 1U << 16U> piece_{};
};

/// The keeper's signals, as a descriptor.
class Signals {
 public:
  explicit Signals(bool in_batch) : on_term_(in_batch ? Stop::in_order : Stop::now) {
    // Reset inherited signal dispositions. Inherited dispositions could hide that children ended,
    // or could end the keeper.
    std::signal(SIGCHLD, SIG_DFL);
    for (const int number : {SIGHUP, SIGPIPE, SIGXFSZ})
      std::signal(number, SIG_IGN);
    sigset_t taken;
    sigemptyset(&taken);
    for (const int number : {SIGCHLD, SIGUSR1, SIGINT, SIGTERM})
      sigaddset(&taken, number);
    if (::sigprocmask(SIG_SETMASK, &taken, nullptr) != 0) fail("can't set up signal handling");
    descriptor_.reset(::signalfd(-1, &taken, SFD_NONBLOCK | SFD_CLOEXEC));
    if (!descriptor_) fail("can't set up signal handling");
  }

  int descriptor() const { return descriptor_.get(); }
  std::optional<Stop> take() {
    std::optional<Stop> asked;
    signalfd_siginfo info{};
    while (::read(descriptor_.get(), &info, sizeof(info)) == sizeof(info)) {
      const int number = static_cast<int>(info.ssi_signo);
      const Stop how = number == SIGTERM ? on_term_ : Stop::in_order;
      if (number != SIGCHLD && asked != Stop::now) asked = how;
    }
    return asked;
  }

 private:
  Stop on_term_;
  base::Descriptor descriptor_;
};

class Kept {
 public:
  Kept(const KeeperOptions& options, const base::Clock& clock, pid_t program)
      : options_(options),
        clock_(clock),
        program_(program),
        is_alone_s_(options.with_ranks ? clock.now_s() + k_first_rank_s : k_never_s) {}

  bool has_ended() const { return status_.has_value(); }
  int status() const { return *status_; }
  KilledFor killed_for() const { return killed_for_; }
  const std::optional<Stop>& stop_asked() const { return stop_asked_; }

  void stop(Stop how) {
    // Forward only the first clean stop, because a second signal would end the run at once.
    const bool was_asked = stop_asked_.has_value();
    stop_asked_ = stop_asked_ == Stop::now ? Stop::now : how;
    if (how == Stop::now) {
      kill_for(KilledFor::asked);
    } else if (was_asked) {
      return;
    } else if (options_.with_ranks && !has_had_ranks_) {
      // mpirun forwards signals only to ranks that already exist, so wait for the first rank.
      is_stop_held_ = true;
    } else {
      ::kill(program_, SIGUSR1);
    }
  }

  /// Collects all children that have ended.
  void reap() {
    int status = 0;
    pid_t ended = 0;
    while ((ended = ::waitpid(-1, &status, WNOHANG)) > 0) {
      if (ended == program_) status_ = status;
    }
  }

  /// Checks for hangs. `has_told`: the program has reported its end.
  void watch(bool has_told) {
    const double now_s = clock_.now_s();
    if (has_told) lingers_s_ = std::min(lingers_s_, now_s + options_.grace_s);
    if (now_s >= lingers_s_) kill_for(KilledFor::lingering);
    if (options_.with_ranks && now_s >= next_look_s_) look_for_ranks(now_s);
  }

  /// Returns the milliseconds until the next check is due.
  int patience_ms() const {
    const double now_s = clock_.now_s();
    double due_s = std::min(now_s + k_patience_s_max, lingers_s_);
    if (options_.with_ranks) due_s = std::min(due_s, next_look_s_);
    return std::max(1, static_cast<int>(1000 * (due_s - now_s) + 1));
  }

 private:
  void kill_for(KilledFor reason) {
    if (has_ended() || killed_for_ != KilledFor::nothing) return;
    killed_for_ = reason;
    ::kill(program_, SIGKILL);
  }

  void look_for_ranks(double now_s) {
    if (has_living_child(program_)) {
      has_had_ranks_ = true;
      is_alone_s_ = k_never_s;
      if (std::exchange(is_stop_held_, false)) ::kill(program_, SIGUSR1);
    } else if (has_had_ranks_) {
      is_alone_s_ = std::min(is_alone_s_, now_s + std::min(options_.grace_s, k_without_ranks_s));
    }
    if (now_s >= is_alone_s_) kill_for(KilledFor::without_ranks);
    next_look_s_ = now_s + (has_had_ranks_ ? k_rank_look_s : k_first_rank_look_s);
  }

  const KeeperOptions& options_;
  const base::Clock& clock_;
  pid_t program_;
  std::optional<int> status_{};
  KilledFor killed_for_ = KilledFor::nothing;
  std::optional<Stop> stop_asked_{};
  bool is_stop_held_ = false;  ///< until the first rank exists
  bool has_had_ranks_ = false;
  double lingers_s_ = k_never_s;  ///< deadline to exit after reporting its end
  double is_alone_s_;             ///< deadline to exit without ranks
  double next_look_s_ = 0;
};

/// Kills and awaits all children. The children's children become this process's children and are
/// killed next.
void end_all_descendants() {
  for (int wait_ms = k_kill_again_ms_min;; wait_ms = std::min(2 * wait_ms, k_kill_again_ms_max)) {
    // These process ids can't have been reused, because nobody has waited for the processes.
    for (const pid_t child : children_of(::getpid()))
      ::kill(child, SIGKILL);
    pid_t ended = 0;
    while ((ended = ::waitpid(-1, nullptr, WNOHANG)) > 0) {
    }
    if (ended < 0 && errno == ECHILD) return;
    ::poll(nullptr, 0, wait_ms);
  }
}

void set_how_it_ended(AttemptEnd& end, int status) {
  if (WIFSIGNALED(status)) {
    end.signal = WTERMSIG(status);
  } else {
    end.exit_code = WEXITSTATUS(status);
  }
}

/// Waits until the program has ended. Then kills its descendants.
AttemptEnd run_program(const KeeperOptions& options, pid_t program, Signals& signals, EndPipe& pipe,
                       Output& output, Moments& moments) {
  const base::SteadyClock clock;
  Kept kept(options, clock, program);
  while (!kept.has_ended()) {
    std::array<pollfd, 3> waits{{{.fd = signals.descriptor(), .events = POLLIN, .revents = 0},
                                 {.fd = pipe.descriptor(), .events = POLLIN, .revents = 0},
                                 {.fd = output.descriptor(), .events = POLLIN, .revents = 0}}};
    if (::poll(waits.data(), waits.size(), kept.patience_ms()) < 0 && errno != EINTR) fail("poll");
    const auto asked = signals.take();
    // Call reap() first. If reap() collected the program, send no signal, because the process id
    // may be reused.
    kept.reap();
    if (asked && !kept.has_ended()) kept.stop(*asked);
    pipe.take();
    output.take(16);
    if (!kept.has_ended()) kept.watch(pipe.told().has_value());
  }
  moments.reached(Moment::program_ended);
  end_all_descendants();
  moments.reached(Moment::alone);
  // All writers have exited, so the remaining output is complete.
  pipe.take();
  while (output.descriptor() >= 0)
    output.take(16);
  AttemptEnd end{.killed_for = kept.killed_for(), .stop_asked = kept.stop_asked()};
  set_how_it_ended(end, kept.status());
  return end;
}

/// Returns the stored end of a session that began during this attempt.
std::optional<events::RunEnd> stored_end(const KeeperOptions& options, const AttemptRecord& record,
                                         BoundedLog& log) {
  const auto sessions = sessions_in(options.folder, log);
  if (sessions.empty() || sessions.back().epoch <= record.epoch_before) return std::nullopt;
  return sessions.back().end;
}

/// Removes the files that a killed mpirun leaves behind.
std::error_code clear_mpi_files(const std::string& folder) {
  std::error_code error;
  std::filesystem::remove_all(folder + "/" + k_mpi_folder_name, error);
  return error;
}

std::string words_of(const AttemptEnd& end) {
  if (!end.not_started.empty()) return end.not_started;
  std::string words = end.signal
                          ? fmt::format("ended by signal {}", *end.signal)
                          : fmt::format("ended with exit code {}", end.exit_code.value_or(0));
  if (end.killed_for == KilledFor::asked) words += ", killed on request";
  if (end.killed_for == KilledFor::lingering)
    words += ", killed because the program reported its end but did not exit";
  if (end.killed_for == KilledFor::without_ranks)
    words += ", killed because mpirun did not exit although no rank was running";
  return words;
}

/// Steps 3 and 4 of keep.h.
AttemptEnd start_and_wait(const KeeperOptions& options, Signals& signals, EndPipe& pipe,
                          BoundedLog& log, Moments& moments) {
  const base::SteadyClock clock;
  const double begun_s = clock.now_s();
  Output output(log);
  const auto program =
      start_program({.command = options.command,
                     .environment = options.in_batch ? whole_environment() : program_environment(),
                     .output = output.writer(),
                     .blocks_sigterm = options.in_batch},
                    moments);
  output.close_writer();
  AttemptEnd end;
  if (program) {
    moments.reached(Moment::started);
    end = run_program(options, program.value(), signals, pipe, output, moments);
  } else {
    end.not_started = program.error();
  }
  end.wall_s = clock.now_s() - begun_s;
  end.log_tail = output.last_lines();
  rusage used{};
  ::getrusage(RUSAGE_CHILDREN, &used);
  end.processor_s = seconds_of(used.ru_utime) + seconds_of(used.ru_stime);
  end.memory_bytes_max = static_cast<std::uint64_t>(used.ru_maxrss) << 10U;
  return end;
}

/// The batch system has started this job twice. Waits for the job's other keeper and forwards
/// signals to it. This keeper must not exit first, because the system would then end both. False:
/// the other keeper has exited or is on another machine.
bool wait_for_other(const ProcessIdentity& other, Signals& signals) {
  bool was_there = false;
  while (is_living(other)) {
    was_there = true;
    if (signals.take()) ::kill(other.pid, SIGUSR1);
    pollfd wait{.fd = signals.descriptor(), .events = POLLIN, .revents = 0};
    ::poll(&wait, 1, k_other_look_ms);
  }
  return was_there;
}

}  // namespace

base::ExitCode keep(const KeeperOptions& options, Moments& moments) {
  CHECK_GT(options.attempt, 0U);
  moments.reached(Moment::begun);
  Signals signals(options.in_batch);
  if (::chdir(options.folder.c_str()) != 0) fail(options.folder);
  const bool marks = options.in_batch && base::network_file_system(options.folder);
  const auto lock = marks ? std::nullopt : KeeperLock::take(options.folder);
  const auto earlier = read_record(options.folder);
  const bool has_begun = earlier && earlier->attempt >= options.attempt;
  if (!marks && !lock && !(options.in_batch && has_begun)) {
    fmt::print(stderr, "sleight-keeper: {}: another keeper uses this folder\n", options.folder);
    return base::ExitCode::conflict;
  }
  if (has_begun) {
    fmt::print(stderr,
               "sleight-keeper: {}: attempt {} has already begun, so attempt {} is not started\n",
               options.folder, earlier->attempt, options.attempt);
    if (options.in_batch && earlier->attempt == options.attempt &&
        wait_for_other(earlier->keeper, signals))
      return base::ExitCode::ok;
    return base::ExitCode::conflict;
  }
  if (marks && !KeeperLock::mark_begun(options.folder, options.attempt)) {
    fmt::print(stderr, "sleight-keeper: {}: attempt {} has already begun\n", options.folder,
               options.attempt);
    return base::ExitCode::conflict;
  }
  moments.reached(Moment::locked);

  if (::prctl(PR_SET_CHILD_SUBREAPER, 1) != 0) fail("PR_SET_CHILD_SUBREAPER");
  if (const auto error = clear_mpi_files(options.folder))
    throw base::Error(fmt::format("{}/{}: {}", options.folder, k_mpi_folder_name, error.message()));
  base::PosixFileSystem files;
  if (options.with_ranks) files.make_folder(options.folder + "/" + k_mpi_folder_name);
  EndPipe pipe(options.folder + "/" + k_pipe_name);
  BoundedLog log(options.folder);
  moments.reached(Moment::prepared);

  const auto self = identity_of(::getpid());
  if (!self) fail("/proc/self/stat");
  const auto sessions = sessions_in(options.folder, log);
  AttemptRecord record{.attempt = options.attempt,
                       .keeper = *self,
                       .command = options.command,
                       .begun_unix_s = unix_now_s(),
                       .epoch_before = sessions.empty() ? 0 : sessions.back().epoch};
  RecordFile file(files, options.folder);
  file.begin(record);
  log.mark(fmt::format("attempt {}: {}", options.attempt, fmt::join(options.command, " ")));
  moments.reached(Moment::recorded);

  AttemptEnd end = start_and_wait(options, signals, pipe, log, moments);
  end.run_end = pipe.told();
  if (!end.run_end) end.run_end = stored_end(options, record, log);
  end.ended_unix_s = unix_now_s();
  log.mark(fmt::format("attempt {}: {}", options.attempt, words_of(end)));
  // Ignore failures here: the next attempt reports them, and this attempt's end must be recorded.
  static_cast<void>(clear_mpi_files(options.folder));
  record.end = std::move(end);
  if (marks) {
    const auto newest = read_record(options.folder);
    if (newest && newest->attempt > options.attempt) {
      fmt::print(
          stderr,
          "sleight-keeper: {}: attempt {} was considered lost, and a later attempt has begun\n",
          options.folder, options.attempt);
      return base::ExitCode::conflict;
    }
  }
  file.end(record);
  moments.reached(Moment::end_recorded);
  return base::ExitCode::ok;
}

}  // namespace sleight::keeper
