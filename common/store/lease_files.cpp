#include "common/store/lease_files.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/random.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <climits>
#include <cstring>
#include <ctime>
#include <filesystem>
#include <string_view>
#include <system_error>
#include <utility>

#include "common/base/check.h"
#include "common/base/error.h"
#include "common/base/file_system.h"

namespace sleight::store {
namespace {

constexpr std::string_view k_prefix = "lease.";
constexpr std::string_view k_new_prefix = "lease.new.";

[[noreturn]] void fail(const std::string& path, const char* action) {
  const int reason = errno;
  throw base::Error(fmt::format("{}: can't {}: {}", path, action, std::strerror(reason)));
}

class Descriptor {
 public:
  explicit Descriptor(int number) : number_(number) {}
  ~Descriptor() {
    if (number_ >= 0) ::close(number_);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  int number() const { return number_; }
  bool is_open() const { return number_ >= 0; }
  int release() { return std::exchange(number_, -1); }

 private:
  int number_;
};

int open_file(const std::string& path, int flags) {
  return ::open(path.c_str(), flags | O_CLOEXEC | O_NOFOLLOW, 0666);
}

/// Writes the text in one call. So a reader on this machine sees either the old text or the new
/// one.
void write_whole(int descriptor, const std::string& path, const std::string& text) {
  const ssize_t put = ::pwrite(descriptor, text.data(), text.size(), 0);
  if (put >= 0 && static_cast<std::size_t>(put) != text.size()) errno = ENOSPC;
  if (put < 0 || static_cast<std::size_t>(put) != text.size()) fail(path, "write");
  if (::fsync(descriptor) != 0) fail(path, "write");
}

std::string read_whole(int descriptor, const std::string& path) {
  std::string text(k_lease_text_bytes + 1, '\0');
  ssize_t got = 0;
  do {
    got = ::pread(descriptor, text.data(), text.size(), 0);
  } while (got < 0 && errno == EINTR);
  if (got < 0) fail(path, "read");
  text.resize(static_cast<std::size_t>(got));
  return text;
}

class OwnFile final : public LeaseFiles::Own {
 public:
  OwnFile(int descriptor, std::string path) : descriptor_(descriptor), path_(std::move(path)) {}
  void write(const std::string& text) override { write_whole(descriptor_.number(), path_, text); }

 private:
  Descriptor descriptor_;
  std::string path_;
};

/// Returns the text of a kernel file; "" if there is none.
std::string kernel_text(const std::string& path) {
  try {
    return base::read_text_file(path, 4096);
  } catch (const base::Error&) {
    return {};
  }
}

/// Returns the start time of a process on this machine, in kernel ticks. Returns nothing if there
/// is no such process, or if it has ended but was not reaped.
std::optional<std::uint64_t> start_of(std::int64_t process) {
  const std::string folder = fmt::format("/proc/{}", process);
  const std::string stat = kernel_text(folder + "/stat");
  // See proc(5). The command's name is in parentheses and may contain anything. The state follows
  // it.
  const std::size_t name_end = stat.rfind(')');
  if (name_end == std::string::npos || name_end + 2 >= stat.size()) return std::nullopt;
  std::string_view rest = std::string_view(stat).substr(name_end + 2);
  constexpr int k_fields_before_start = 19;
  const char state = rest[0];
  for (int field = 0; field < k_fields_before_start; ++field) {
    const std::size_t space = rest.find(' ');
    if (space == std::string_view::npos) return std::nullopt;
    rest.remove_prefix(space + 1);
  }
  std::uint64_t start = 0;
  std::from_chars(rest.data(), rest.data() + rest.size(), start);
  if (state == 'X') return std::nullopt;
  if (state != 'Z') return start;
  // The first thread has ended; other threads may still run.
  std::error_code failure;
  const std::filesystem::directory_iterator threads(folder + "/task", failure);
  if (failure || std::distance(begin(threads), end(threads)) <= 1) return std::nullopt;
  return start;
}

/// Error codes that a server may return if the disk doesn't support links.
bool has_no_links(int reason) {
  return reason == EPERM || reason == EOPNOTSUPP || reason == ENOSYS || reason == EMLINK;
}

}  // namespace

LeaseHolder this_process() {
  std::array<char, HOST_NAME_MAX + 1> host{};
  if (::gethostname(host.data(), host.size() - 1) != 0) host[0] = '\0';
  // `boot` identifies a boot of the machine. Within a boot, `space` identifies a namespace of
  // process ids.
  std::string boot = kernel_text("/proc/sys/kernel/random/boot_id");
  boot = boot.substr(0, boot.find('\n'));
  std::error_code failure;
  const std::string space = std::filesystem::read_symlink("/proc/self/ns/pid", failure).string();
  const std::int64_t process = ::getpid();
  std::tm time{};
  const std::time_t now = std::time(nullptr);
  ::gmtime_r(&now, &time);
  std::array<char, 32> since{};
  std::strftime(since.data(), since.size(), "%Y-%m-%d %H:%M:%S UTC", &time);
  LeaseHolder self{.host = host.data(),
                   .process = process,
                   .started = start_of(process).value_or(0),
                   .since = since.data()};
  if (!boot.empty() && !space.empty())
    self.machine = fmt::format("{}/{}/{}", self.host, boot, space);
  return self;
}

std::string make_token() {
  std::array<std::uint64_t, 2> random{};
  // Fail if there are no random bytes. Otherwise two processes could mistake each other's file for
  // their own.
  CHECK_EQ(::getrandom(random.data(), sizeof random, 0), static_cast<ssize_t>(sizeof random));
  return fmt::format("{:016x}{:016x}", random[0], random[1]);
}

PosixLeaseFiles::PosixLeaseFiles(std::string folder, LeaseHolder self)
    : folder_(std::move(folder)), self_(std::move(self)) {}

std::string PosixLeaseFiles::path_of(std::uint64_t generation) const {
  return fmt::format("{}/{}{}", folder_, k_prefix, generation);
}

std::vector<std::uint64_t> PosixLeaseFiles::list() {
  std::vector<std::uint64_t> generations;
  for (const std::string& name : base::PosixFileSystem().names_in(folder_)) {
    if (!name.starts_with(k_prefix)) continue;
    const char* const end = name.data() + name.size();
    std::uint64_t generation = 0;
    const auto [rest, failure] = std::from_chars(name.data() + k_prefix.size(), end, generation);
    if (failure == std::errc() && rest == end && generation > 0) generations.push_back(generation);
  }
  std::ranges::sort(generations);
  return generations;
}

std::optional<std::string> PosixLeaseFiles::read(std::uint64_t generation) {
  const std::string path = path_of(generation);
  const Descriptor file(open_file(path, O_RDONLY));
  if (!file.is_open()) {
    // The server may return ESTALE for a file that another machine has just removed.
    if (errno == ENOENT || errno == ESTALE) return std::nullopt;
    fail(path, "open");
  }
  return read_whole(file.number(), path);
}

std::unique_ptr<LeaseFiles::Own> PosixLeaseFiles::make(std::uint64_t generation,
                                                       const std::string& text) {
  const std::string path = path_of(generation);
  const std::string unique = fmt::format("{}/{}{}", folder_, k_new_prefix, make_token());
  {
    const Descriptor file(open_file(unique, O_RDWR | O_CREAT | O_EXCL));
    if (!file.is_open()) fail(unique, "create");
    write_whole(file.number(), unique, text);
  }
  if (::link(unique.c_str(), path.c_str()) != 0 && has_no_links(errno)) {
    const Descriptor file(open_file(path, O_RDWR | O_CREAT | O_EXCL));
    if (file.is_open()) write_whole(file.number(), path, text);
  }
  ::unlink(unique.c_str());

  // Read the content to find out who created the file. The result of link() is uncertain: after a
  // lost answer, the system may have repeated the call.
  Descriptor file(open_file(path, O_RDWR));
  if (!file.is_open()) {
    if (errno == ENOENT || errno == ESTALE) return nullptr;
    fail(path, "create");
  }
  if (read_whole(file.number(), path) != text) return nullptr;

  // Remove leftovers of killed processes. If a live process loses its file, it tries again and
  // finds this lease.
  for (const std::string& name : base::PosixFileSystem().names_in(folder_)) {
    if (name.starts_with(k_new_prefix)) ::unlink((folder_ + "/" + name).c_str());
  }
  return std::make_unique<OwnFile>(file.release(), path);
}

void PosixLeaseFiles::remove(std::uint64_t generation) {
  const std::string path = path_of(generation);
  if (::unlink(path.c_str()) != 0 && errno != ENOENT) fail(path, "remove");
}

bool PosixLeaseFiles::is_gone(const LeaseHolder& holder) {
  return !self_.machine.empty() && holder.machine == self_.machine &&
         start_of(holder.process) != holder.started;
}

bool PosixLeaseFiles::is_here(const LeaseHolder& holder) {
  return !self_.machine.empty() && holder.machine == self_.machine &&
         start_of(holder.process) == holder.started;
}

bool PosixLeaseFiles::any_held(const std::string& folder) {
  PosixLeaseFiles files(folder, {});
  const std::vector<std::uint64_t> all = files.list();
  if (all.empty()) return false;
  const std::optional<std::string> text = files.read(all.back());
  const auto lease = text ? LeaseText::from_text(*text) : std::nullopt;
  return !lease || !lease->is_released;
}

}  // namespace sleight::store
