#include "service/daemon/audit_log.h"

#include <fcntl.h>
#include <fmt/chrono.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cstdio>
#include <ctime>
#include <nlohmann/json.hpp>
#include <utility>

namespace sleight::daemon {
namespace {

constexpr double k_strangers_every_s = 1;

std::string time_now() {
  return fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(std::time(nullptr)));
}

/// In the order in which they are written.
std::string text_of(const nlohmann::ordered_json& line) {
  return line.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
}

}  // namespace

AuditLog::AuditLog(std::string folder, const base::Clock& clock, std::uint64_t bytes_max)
    : folder_(std::move(folder)), clock_(clock), bytes_max_(bytes_max) {}

AuditLog::~AuditLog() {
  strangers_told_s_ = -1e9;
  flush();
}

void AuditLog::note(const rpc::Caller& caller, const AuditLine& line) {
  nlohmann::ordered_json json{{"time", time_now()}, {"call", line.call}, {"user", caller.user}};
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
  if (strangers_ == 0 || now_s - strangers_told_s_ < k_strangers_every_s) return;
  strangers_told_s_ = now_s;
  nlohmann::ordered_json json{
      {"time", time_now()}, {"call", "login"}, {"from", last_stranger_}, {"outcome", "refused"}};
  const std::uint64_t times = std::exchange(strangers_, 0);
  if (times > 1) json["times"] = times;
  write(text_of(json));
}

void AuditLog::write(const std::string& line) {
  const std::string path = folder_ + "/audit.log";
  if (file_ && bytes_ + line.size() > bytes_max_) {
    file_.reset();
    static_cast<void>(std::rename(path.c_str(), (folder_ + "/audit.old.log").c_str()));
  }
  if (!file_) {
    file_.reset(::open(path.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC | O_NOFOLLOW, 0600));
    struct stat seen = {};
    bytes_ =
        file_ && ::fstat(file_.get(), &seen) == 0 ? static_cast<std::uint64_t>(seen.st_size) : 0;
  }
  std::string whole;
  if (lost_ > 0)
    whole = text_of({{"time", time_now()}, {"call", "lines were lost"}, {"times", lost_}});
  whole += line;
  // One call: a daemon that is killed leaves whole lines, but for the last one.
  const ssize_t put = file_ ? ::write(file_.get(), whole.data(), whole.size()) : -1;
  if (put == static_cast<ssize_t>(whole.size())) {
    lost_ = 0;
    bytes_ += whole.size();
  } else {
    ++lost_;
  }
}

}  // namespace sleight::daemon
