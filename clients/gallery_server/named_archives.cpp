#include "clients/gallery_server/named_archives.h"

#include <cstdlib>
#include <filesystem>
#include <span>
#include <system_error>
#include <variant>

#include <fmt/format.h>

#include "clients/cli/job_names.h"
#include "clients/cli/service_call.h"
#include "common/base/error.h"
#include "common/rpc/client.h"

namespace sleight::gallery {
namespace {

namespace fs = std::filesystem;

rpc::JobId job_of(const std::string& text, const std::string& socket) {
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
  return *job;
}

}  // namespace

NamedArchives::NamedArchives(const std::vector<std::string>& texts, const std::string& socket) {
  for (const std::string& text : texts) {
    std::error_code failure;
    if (fs::exists(text, failure)) {
      paths_.push_back(text);
    } else {
      jobs_.push_back({.id = job_of(text, socket)});
      paths_.emplace_back();
    }
  }
  if (jobs_.empty()) return;
  std::string form = (fs::temp_directory_path() / "sleight-gallery-XXXXXX").string();
  if (::mkdtemp(form.data()) == nullptr)
    throw base::Error(fmt::format("{}: can't make a folder there", form));
  folder_ = form;
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

}  // namespace sleight::gallery
