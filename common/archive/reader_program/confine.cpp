#include "common/archive/reader_program/confine.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <seccomp.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <memory>
#include <string_view>

#include "common/archive/remote/messages.h"
#include "common/base/error.h"

namespace sleight::archive::reader_program {
namespace {

void require(bool is_done, std::string_view what, int reason) {
  if (is_done) return;
  throw base::Error(fmt::format("can't {}: {}; archives are only read in a sandbox", what,
                                std::strerror(reason)));
}

void limit(__rlimit_resource_t resource, rlim_t most, std::string_view what) {
  rlimit now{};
  require(::getrlimit(resource, &now) == 0, what, errno);
  now.rlim_max = std::min(now.rlim_max, most);
  now.rlim_cur = now.rlim_max;
  require(::setrlimit(resource, &now) == 0, what, errno);
}

/// The permitted system calls; any other kills the process.
class Permits {
 public:
  Permits() : filter_(::seccomp_init(SCMP_ACT_KILL_PROCESS), &::seccomp_release) {
    require(filter_ != nullptr, "create a system-call filter", ENOMEM);
  }

  void permit(int call) { note(::seccomp_rule_add(filter_.get(), SCMP_ACT_ALLOW, call, 0)); }

  /// Permits the system call if its nth argument & `mask` equals `value`. `argument`: n, counted
  /// from 0.
  void permit_if(int call, unsigned argument, std::uint64_t mask, std::uint64_t value) {
    const scmp_arg_cmp is_it{argument, SCMP_CMP_MASKED_EQ, mask, value};
    note(::seccomp_rule_add_array(filter_.get(), SCMP_ACT_ALLOW, call, 1, &is_it));
  }

  void permit_of(int call, int descriptor) {
    permit_if(call, 0, 0xffffffffU, static_cast<std::uint32_t>(descriptor));
  }

  void load() {
    note(::seccomp_attr_set(filter_.get(), SCMP_FLTATR_CTL_TSYNC, 1));
    note(::seccomp_load(filter_.get()));
    require(reason_ == 0, "restrict system calls", -reason_);
  }

 private:
  void note(int result) {
    if (reason_ == 0) reason_ = result;
  }
  std::unique_ptr<void, decltype(&::seccomp_release)> filter_;
  int reason_ = 0;
};

void permit_what_reading_needs(Permits& permits) {
  // Archive, questions and answers.
  permits.permit_of(SCMP_SYS(read), remote::k_questions_descriptor);
  permits.permit_of(SCMP_SYS(write), remote::k_answers_descriptor);
  permits.permit_of(SCMP_SYS(pread64), remote::k_archive_descriptor);
  permits.permit_of(SCMP_SYS(close), remote::k_archive_descriptor);
  // Memory, but never executable.
  permits.permit_if(SCMP_SYS(mmap), 2, PROT_EXEC, 0);
  permits.permit_if(SCMP_SYS(mprotect), 2, PROT_EXEC, 0);
  for (const int call : {SCMP_SYS(brk), SCMP_SYS(munmap), SCMP_SYS(mremap), SCMP_SYS(madvise),
                         SCMP_SYS(futex), SCMP_SYS(getrandom)})
    permits.permit(call);
  // Permit reading the time, for kernels that need a system call for it.
  permits.permit(SCMP_SYS(clock_gettime));
  permits.permit(SCMP_SYS(gettimeofday));
  // Permit sleeping: HDF5 sleeps for a nanosecond before rereading metadata with a wrong checksum.
  permits.permit(SCMP_SYS(nanosleep));
  permits.permit(SCMP_SYS(clock_nanosleep));
  // Normal exit and abort().
  for (const int call :
       {SCMP_SYS(exit), SCMP_SYS(exit_group), SCMP_SYS(rt_sigreturn), SCMP_SYS(rt_sigprocmask),
        SCMP_SYS(rt_sigaction), SCMP_SYS(getpid), SCMP_SYS(gettid), SCMP_SYS(restart_syscall)})
    permits.permit(call);
  permits.permit_of(SCMP_SYS(tgkill), ::getpid());
}

#ifdef SLEIGHT_SANITIZED
void permit_what_sanitizers_need(Permits& permits) {
  constexpr std::uint64_t k_changing = O_ACCMODE | O_CREAT | O_TRUNC | O_APPEND;
  permits.permit_if(SCMP_SYS(openat), 2, k_changing, O_RDONLY);
  permits.permit_if(SCMP_SYS(open), 1, k_changing, O_RDONLY);
  for (const int call :
       {SCMP_SYS(read), SCMP_SYS(write), SCMP_SYS(close), SCMP_SYS(pipe), SCMP_SYS(pipe2),
        SCMP_SYS(fstat), SCMP_SYS(newfstatat), SCMP_SYS(stat), SCMP_SYS(readlink),
        SCMP_SYS(readlinkat), SCMP_SYS(lseek), SCMP_SYS(ioctl), SCMP_SYS(getcwd),
        SCMP_SYS(sigaltstack), SCMP_SYS(sched_getaffinity), SCMP_SYS(sched_yield),
        SCMP_SYS(getrlimit), SCMP_SYS(getrusage), SCMP_SYS(access)})
    permits.permit(call);
}
#endif

}  // namespace

void end_with_lifeline(int lifeline) {
  // The kernel signals each change of the pipe. Nobody writes to the pipe, so a signal means that
  // its other end was closed. The signal's default action ends the process even in an endless loop.
  const bool is_armed = ::fcntl(lifeline, F_SETOWN, ::getpid()) == 0 &&
                        ::fcntl(lifeline, F_SETFL, O_ASYNC | O_NONBLOCK) == 0;
  require(is_armed, "watch the parent process", errno);
  // The other end may have been closed already.
  pollfd watched{lifeline, POLLIN, 0};
  if (::poll(&watched, 1, 0) != 0) ::_exit(0);
}

void confine(std::uint64_t address_space_bytes) {
  limit(RLIMIT_CORE, 0, "disable core dumps");
  limit(RLIMIT_FSIZE, 0, "disable writing to files");
#ifdef SLEIGHT_SANITIZED
  (void)address_space_bytes;
#else
  limit(RLIMIT_AS, address_space_bytes, "limit memory");
  // Lower the limit of descriptors, so that no number is left for opening another file.
  limit(RLIMIT_NOFILE, remote::k_lifeline_descriptor + 1, "disable opening of files");
#endif
  require(::prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) == 0, "drop privileges", errno);
  Permits permits;
  permit_what_reading_needs(permits);
#ifdef SLEIGHT_SANITIZED
  permit_what_sanitizers_need(permits);
#endif
  permits.load();
}

}  // namespace sleight::archive::reader_program
