#include "service/daemon/audit_log.h"

#include <fcntl.h>
#include <fmt/chrono.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <ctime>
#include <system_error>

#include "common/json/value.h"
#include "common/logging/log.h"

namespace sleight::daemon {
namespace {

constexpr double k_strangers_every_s = 1;
constexpr double k_lines_per_s = 0.1;  // sustained rate per user and call
constexpr double k_more_every_s = 10;
constexpr double k_due_s = 1e300;  // later than any clock

std::string time_now() {
  return fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(std::time(nullptr)));
}

std::string text_of(const json::Value& line) {
  return line.dump() + "\n";
}

}  // namespace

AuditLog::AuditLog(std::string folder, const base::Clock& clock, std::uint64_t bytes_max)
    : folder_(std::move(folder)), clock_(clock), bytes_max_(bytes_max) {}

AuditLog::~AuditLog() {
  tell_strangers(k_due_s);
  tell_more(k_due_s);
}

void AuditLog::note(const rpc::Caller& caller, const rpc::AuditLine& line) {
  flush();
  const double now_s = clock_.now_s();
  Share& share =
      shares_.try_emplace({caller.user, line.call}, Share{.since_s = now_s, .told_s = now_s})
          .first->second;
  share.lines = std::min(k_audit_burst, share.lines + k_lines_per_s * (now_s - share.since_s));
  share.since_s = now_s;
  if (share.lines < 1) {
    ++share.more;
    return;
  }
  share.lines -= 1;
  json::Value json{{"time", time_now()}, {"call", line.call}, {"user", caller.user}};
  json["from"] = caller.address.empty() ? fmt::format("process {}", caller.pid) : caller.address;
  if (!caller.token_id.empty()) json["token"] = caller.token_id;
  if (!line.of.empty()) json["of"] = line.of;
  json["outcome"] = line.outcome;
  if (!line.made.empty()) json["made"] = line.made;
  write(text_of(json));
}

void AuditLog::note_stranger(const std::string& address) {
  ++strangers_;
  last_stranger_ = address;
  flush();
}

void AuditLog::flush() {
  const double now_s = clock_.now_s();
  tell_strangers(now_s);
  tell_more(now_s);
}

void AuditLog::tell_strangers(double now_s) {
  if (strangers_ == 0 || now_s - strangers_told_s_ < k_strangers_every_s) return;
  strangers_told_s_ = now_s;
  json::Value json{
      {"time", time_now()}, {"call", "login"}, {"from", last_stranger_}, {"outcome", "refused"}};
  const std::uint64_t times = std::exchange(strangers_, 0);
  if (times > 1) json["times"] = times;
  write(text_of(json));
}

void AuditLog::tell_more(double now_s) {
  for (auto& [what, share] : shares_) {
    if (share.more == 0 || now_s - share.told_s < k_more_every_s) continue;
    share.told_s = now_s;
    write(text_of({{"time", time_now()},
                   {"call", what.second},
                   {"user", what.first},
                   {"more", std::exchange(share.more, 0)}}));
  }
}

/// Opens the file. If this function fails, it is called again for each further line.
void AuditLog::open_file() {
  const std::string path = folder_ + "/audit.log";
  // O_NONBLOCK: if the file is a pipe, opening it must not block the daemon.
  file_.reset(::open(path.c_str(),
                     O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK, 0600));
  const int error = file_ ? EINVAL : errno;
  struct stat seen = {};
  if (file_ && (::fstat(file_.get(), &seen) != 0 || !S_ISREG(seen.st_mode))) file_.reset();
  bytes_ = file_ ? static_cast<std::uint64_t>(seen.st_size) : 0;
  if (file_ || lost_ > 0) return;
  logging::warn(
      fmt::format("{}: can't write the audit log ({}); calls are not recorded until the path is a "
                  "regular file again",
                  path, std::system_category().message(error)));
}

void AuditLog::write(const std::string& line) {
  const std::string path = folder_ + "/audit.log";
  if (file_ && bytes_ + line.size() > bytes_max_) {
    file_.reset();
    static_cast<void>(std::rename(path.c_str(), (folder_ + "/audit.old.log").c_str()));
  }
  if (!file_) open_file();
  std::string whole;
  if (lost_ > 0)
    whole = text_of({{"time", time_now()}, {"call", "lines were lost"}, {"times", lost_}});
  whole += line;
  // Write a line with one call. If the daemon is killed, all lines are then whole, except perhaps
  // the last.
  const ssize_t put = file_ ? ::write(file_.get(), whole.data(), whole.size()) : -1;
  if (put == static_cast<ssize_t>(whole.size())) {
    lost_ = 0;
    bytes_ += whole.size();
  } else {
    ++lost_;
  }
}

base::Result<rpc::Caller, rpc::Refusal> AuditedAuthority::login(const std::string& token,
                                                                const std::string& address) {
  auto caller = inner_.login(token, address);
  if (caller) {
    audit_.note(caller.value(), {.call = "login", .outcome = "done"});
  } else {
    audit_.note_stranger(address);
  }
  return caller;
}

}  // namespace sleight::daemon
