#include "clients/gallery_server/named_archives.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <span>
#include <string_view>
#include <system_error>
#include <tuple>
#include <utility>
#include <variant>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "clients/service_client/job_names.h"
#include "clients/service_client/service_call.h"
#include "common/base/error.h"
#include "common/rpc/client.h"

namespace sleight::gallery {
namespace {

namespace fs = std::filesystem;

rpc::JobId job_of(const std::string& text, std::string& service,
                  const std::function<std::string()>& service_called) {
  const auto names = service_client::job_names_of(std::span(&text, 1));
  if (!names) {
    throw base::Error(base::ExitCode::environment,
                      fmt::format("{}: no such archive or folder", text));
  }
  const auto* job = std::get_if<rpc::JobId>(&names.value().front());
  if (job == nullptr) {
    throw base::Error(
        base::ExitCode::usage,
        fmt::format("{}: names several jobs; give each job's number separately", text));
  }
  // Check the job here, so that a missing job or service is reported at once.
  if (service.empty()) service = service_called();
  service_client::with_service(service, [&](rpc::Client& client) {
    client.status(*job);
    return 0;
  });
  return *job;
}

constexpr std::string_view k_folder = "sleight-gallery-";
constexpr std::string_view k_any = "XXXXXX";  ///< mkdtemp replaces it

/// Locks a folder of this user by flock(how); returns none if that fails.
base::Descriptor locked(const std::string& folder, int how) {
  base::Descriptor opened(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC));
  struct stat found {};
  const bool is_locked = opened && ::fstat(opened.get(), &found) == 0 &&
                         found.st_uid == ::geteuid() && ::flock(opened.get(), how) == 0;
  return is_locked ? std::move(opened) : base::Descriptor();
}

/// Creates and locks a new folder.
std::pair<std::string, base::Descriptor> new_folder(const std::string& temporary) {
  constexpr int k_attempts = 10;
  std::string form;
  for (int attempt = 0; attempt < k_attempts; ++attempt) {
    form = fmt::format("{}/{}{}", temporary, k_folder, k_any);
    if (::mkdtemp(form.data()) == nullptr) break;
    base::Descriptor lock = locked(form, LOCK_EX);
    // Before this gallery locked the folder, another gallery may have removed it as abandoned.
    std::error_code failure;
    if (fs::exists(form, failure)) return {form, std::move(lock)};
  }
  throw base::Error(fmt::format("{}: cannot create this folder", form));
}

}  // namespace

void remove_abandoned_folders(const std::string& temporary) {
  std::error_code failure;
  for (fs::directory_iterator item(temporary, failure), end; !failure && item != end;
       item.increment(failure)) {
    const std::string name = item->path().filename().string();
    if (!name.starts_with(k_folder) || name.size() != k_folder.size() + k_any.size()) continue;
    std::error_code none;
    if (const base::Descriptor lock = locked(item->path().string(), LOCK_EX | LOCK_NB))
      fs::remove_all(item->path(), none);
  }
}

NamedArchives::NamedArchives(const std::vector<std::string>& texts,
                             const std::function<std::string()>& service_called) {
  for (const std::string& text : texts) {
    std::error_code failure;
    if (fs::exists(text, failure)) {
      paths_.push_back(text);
    } else {
      jobs_.push_back({.id = job_of(text, service_, service_called)});
      paths_.emplace_back();
    }
  }
  const std::string temporary = fs::temp_directory_path().string();
  remove_abandoned_folders(temporary);
  if (jobs_.empty()) return;
  std::tie(folder_, lock_) = new_folder(temporary);
  auto next = jobs_.begin();
  for (std::string& path : paths_) {
    if (!path.empty()) continue;
    path = next->path = fmt::format("{}/job-{}.h5", folder_, next->id.value);
    ++next;
  }
}

NamedArchives::~NamedArchives() {
  std::error_code failure;
  if (!folder_.empty()) fs::remove_all(folder_, failure);
}

std::string nothing_to_show(const json::Value& state, const std::vector<std::string>& paths) {
  const auto& archives = state["archives"];
  const auto is_of = [](const char* word) {
    return [word](const auto& archive) { return archive["state"] == word; };
  };
  if (archives.empty()) {
    const auto& left_out = state["left_out"];
    const std::string besides =
        left_out.empty()
            ? std::string()
            : fmt::format(" (skipped: {}: {})", left_out[0]["name"].template get<std::string>(),
                          left_out[0]["reason"].template get<std::string>());
    return terminal::shown_on_one_line(
        fmt::format("{}: no archive (*.h5) to show{}; name an archive or its folder (subfolders "
                    "are not searched), or wait until an archive appears",
                    fmt::join(paths, ", "), besides));
  }
  // The page shows what was read of a damaged archive, and a job's archive may still appear.
  if (!std::ranges::all_of(archives.elements(), is_of("damaged"))) return {};
  if (std::ranges::any_of(archives.elements(),
                          [](const auto& one) { return one["generation"] != 0; }))
    return {};
  const auto& first = archives[0];
  const std::string more =
      archives.size() == 1 ? std::string() : fmt::format(" (and {} more)", archives.size() - 1);
  return terminal::shown_on_one_line(fmt::format(
      "nothing to show: {}: {}{}; name an archive that "
      "`sleight direct` wrote, or wait until the file is replaced",
      first["name"].template get<std::string>(), first["words"].template get<std::string>(), more));
}

}  // namespace sleight::gallery
