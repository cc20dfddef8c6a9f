#include "service/daemon/job_folder.h"

#include <fmt/format.h>
#include <sys/statvfs.h>

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <system_error>

#include "common/base/replaced_file.h"

#include "service/keeper/command.h"

namespace sleight::daemon {
namespace {

constexpr const char* k_aside = ".deleted-";

}  // namespace

std::string JobFolders::folder(jobs::JobId job) const {
  return fmt::format("{}/{}", all(), job.value);
}
std::string JobFolders::request(jobs::JobId job) const {
  return folder(job) + "/" + keeper::k_request_name;
}
std::string JobFolders::archive(jobs::JobId job) const {
  return folder(job) + "/" + keeper::k_output_name;
}
std::string JobFolders::run(jobs::JobId job) const {
  return archive(job) + ".run";
}
std::string JobFolders::failures(jobs::JobId job) const {
  return run(job) + "/failures";
}

void JobFolders::write_request(jobs::JobId job, const std::string& text,
                               base::FileSystem& files) const {
  files.make_folder(all());
  files.make_folder(folder(job));
  base::replace_text_file(files, request(job), text);
  files.sync_directory_of(folder(job));
}

std::uint64_t JobFolders::highest() const {
  std::uint64_t highest = 0;
  std::error_code reason;
  std::filesystem::directory_iterator folders(all(), reason);
  if (reason) return 0;
  for (const auto& entry : folders) {
    const std::string name = entry.path().filename().string();
    std::uint64_t number = 0;
    const auto [rest, failure] = std::from_chars(name.data(), name.data() + name.size(), number);
    if (failure == std::errc() && rest == name.data() + name.size())
      highest = std::max(highest, number);
  }
  return highest;
}

bool JobFolders::set_aside(jobs::JobId job) const {
  std::error_code reason;
  std::filesystem::rename(folder(job), fmt::format("{}/{}{}", all(), k_aside, job.value), reason);
  return !reason;
}

void JobFolders::clear_away() const {
  std::error_code reason;
  std::filesystem::directory_iterator folders(all(), reason);
  if (reason) return;
  for (const auto& entry : folders) {
    if (entry.path().filename().string().starts_with(k_aside))
      std::filesystem::remove_all(entry.path(), reason);
  }
}

std::uint64_t JobFolders::bytes(jobs::JobId job) const {
  std::error_code reason;
  std::uint64_t sum = 0;
  std::filesystem::recursive_directory_iterator entry(
      folder(job), std::filesystem::directory_options::skip_permission_denied, reason);
  while (!reason && entry != std::filesystem::recursive_directory_iterator()) {
    std::error_code unknown;
    if (entry->is_regular_file(unknown)) {
      const std::uint64_t size = entry->file_size(unknown);
      if (!unknown) sum += size;
    }
    entry.increment(reason);
  }
  return sum;
}

std::uint64_t disk_free_bytes(const std::string& folder) {
  struct statvfs disk {};
  if (::statvfs(folder.c_str(), &disk) != 0) return 0;
  return static_cast<std::uint64_t>(disk.f_bavail) * disk.f_frsize;
}

}  // namespace sleight::daemon
