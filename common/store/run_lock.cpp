#include "common/store/run_lock.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <condition_variable>
#include <cstdlib>
#include <cstring>
#include <mutex>
#include <thread>
#include <utility>
#include <variant>

#include "common/base/error.h"
#include "common/base/network_disk.h"
#include "common/logging/log.h"
#include "common/store/lease_files.h"

namespace sleight::store {
namespace {

/// Interval between checks of stop_requested and of another holder's lease.
constexpr std::chrono::milliseconds k_look_every(100);

std::string name_of(const LeaseText& lease) {
  std::string name = fmt::format("process ({}) on {}", lease.holder.process, lease.holder.host);
  if (!lease.holder.since.empty()) name += fmt::format(", since {}", lease.holder.since);
  if (lease.epoch > 0) name += fmt::format(", session {}", lease.epoch);
  return name;
}

[[noreturn]] void refuse_held(const std::string& folder, const std::optional<LeaseText>& by) {
  throw base::Error(
      base::ExitCode::conflict,
      by ? fmt::format("{}: another {}, is writing this run; wait for it, or stop it first", folder,
                       name_of(*by))
         : fmt::format("{}: another process is writing this run (its lease can't be read); wait "
                       "for it, or stop it first",
                       folder));
}

}  // namespace

struct RunLock::Leased {
  Leased(std::string place, const RunLockOptions& options)
      : folder(std::move(place)),
        self(options.self.value_or(this_process())),
        files(folder, self),
        lease(files, clock, {.holder = self, .token = make_token(), .lease_s = options.lease_s}) {}
  ~Leased() {
    {
      const std::scoped_lock lock(mutex);
      is_ending = true;
    }
    changed.notify_all();
    if (thread.joinable()) thread.join();
    try {
      lease.release();
    } catch (const base::Error&) {
      // Ignore the failure: the disk is unavailable, so the lease expires by itself.
    }
  }
  Leased(const Leased&) = delete;
  Leased& operator=(const Leased&) = delete;

  void take(const RunLockOptions& options);
  void renew_if_due() {
    if (clock.now_s() - last_s >= lease.renew_every_s()) renew_now();
  }
  void renew_now();
  void renew_always();

  std::string folder;
  LeaseHolder self;
  base::BootClock clock;
  PosixLeaseFiles files;
  mutable std::mutex mutex;  ///< guards all members below, and `lease` except may_act
  Lease lease;
  double last_s = 0;  ///< time of the last attempt to renew
  std::condition_variable changed;
  bool is_ending = false;
  std::thread thread;
};

void RunLock::Leased::take(const RunLockOptions& options) {
  bool is_told = false;
  while (true) {
    const Lease::Outcome outcome = lease.try_take();
    if (std::holds_alternative<Lease::Taken>(outcome)) break;
    if (const auto* held = std::get_if<Lease::Held>(&outcome)) refuse_held(folder, held->by);
    const auto& unsure = std::get<Lease::Unsure>(outcome);
    if (unsure.left_s > 0 && !options.waits) refuse_held(folder, unsure.by);
    if (unsure.left_s > 2 * lease.renew_every_s() && !std::exchange(is_told, true)) {
      logging::info(
          fmt::format("{}: another {}, holds the run lease; this process takes over unless the "
                      "lease is renewed within {:.0f} s",
                      folder, unsure.by ? name_of(*unsure.by) : "process", unsure.left_s));
    }
    std::this_thread::sleep_for(k_look_every);
    if (options.stop_requested && options.stop_requested()) {
      throw base::Error(base::ExitCode::interrupted,
                        fmt::format("{}: interrupted while waiting for the run lease", folder));
    }
  }
  last_s = clock.now_s();
}

void RunLock::Leased::renew_now() {
  last_s = clock.now_s();
  try {
    (void)lease.renew();
  } catch (const base::Error&) {
    // The disk failed. A failed renewal is repeated until the lease ends. After the end, check()
    // throws.
  }
}

void RunLock::Leased::renew_always() {
  std::unique_lock lock(mutex);
  const std::chrono::duration<double> pause(lease.renew_every_s());
  while (!changed.wait_for(lock, pause, [&] { return is_ending; }))
    renew_now();
}

RunLock::RunLock(const std::string& folder, RunLockOptions options) : folder_(folder) {
  if (::mkdir(folder.c_str(), 0777) != 0 && errno != EEXIST) {
    throw base::Error(
        fmt::format("{}: can't create the run's folder: {}", folder, std::strerror(errno)));
  }
  if (base::network_file_system(folder) || PosixLeaseFiles::any_held(folder)) {
    leased_ = std::make_unique<Leased>(folder, options);
    leased_->take(options);
  } else {
    flock_it();
  }
}

void RunLock::flock_it() {
  const std::string path = folder_ + "/lock";
  descriptor_ = ::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0666);
  if (descriptor_ < 0) {
    throw base::Error(fmt::format("{}: can't open: {}", path, std::strerror(errno)));
  }
  if (::flock(descriptor_, LOCK_EX | LOCK_NB) != 0) {
    std::array<char, 32> holder{};
    const ssize_t size = ::read(descriptor_, holder.data(), holder.size() - 1);
    ::close(descriptor_);
    const long process = size > 0 ? std::strtol(holder.data(), nullptr, 10) : 0;
    throw base::Error(
        base::ExitCode::conflict,
        fmt::format("{}: another process{} is writing this run; wait for it, or stop it first",
                    folder_, process > 0 ? fmt::format(" ({})", process) : std::string()));
  }
  const std::string holder = fmt::format("{}\n", ::getpid());
  if (::ftruncate(descriptor_, 0) != 0 ||
      ::pwrite(descriptor_, holder.data(), holder.size(), 0) < 0) {
    const int reason = errno;
    ::close(descriptor_);
    throw base::Error(fmt::format("{}: can't write: {}", path, std::strerror(reason)));
  }
}

RunLock::~RunLock() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

void RunLock::keep() {
  if (!leased_ || leased_->thread.joinable()) return;
  {
    const std::scoped_lock lock(leased_->mutex);
    leased_->renew_now();  // makes what was set since taking the lease readable
  }
  leased_->thread = std::thread([lock = leased_.get()] { lock->renew_always(); });
}

void RunLock::renew() {
  if (!leased_) return;
  const std::scoped_lock lock(leased_->mutex);
  leased_->renew_if_due();
}

void RunLock::check() const {
  if (!leased_ || leased_->lease.may_act()) return;
  std::optional<LeaseText> by;
  try {
    const std::scoped_lock lock(leased_->mutex);
    by = leased_->lease.successor();
  } catch (const base::Error&) {
    // The new holder isn't known here. The next start will report it.
  }
  throw base::Error(
      base::ExitCode::conflict,
      fmt::format("{}: the run lease on the network disk could not be renewed in time, and {}; "
                  "this process stops, and results that were not stored are computed again",
                  folder_,
                  by ? fmt::format("another {}, has taken over the run", name_of(*by))
                     : std::string("another process may have taken over the run")));
}

void RunLock::set_epoch(std::uint64_t epoch) {
  if (!leased_) return;
  const std::scoped_lock lock(leased_->mutex);
  leased_->lease.set_epoch(epoch);
}

bool RunLock::owes_copies() const {
  if (!leased_) return false;
  const std::scoped_lock lock(leased_->mutex);
  return leased_->lease.owes_copies();
}

void RunLock::set_copied() {
  if (!leased_) return;
  const std::scoped_lock lock(leased_->mutex);
  leased_->lease.set_copied();
}

}  // namespace sleight::store
