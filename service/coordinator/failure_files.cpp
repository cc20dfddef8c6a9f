#include "service/coordinator/failure_files.h"

#include <algorithm>
#include <cstdint>
#include <string_view>
#include <utility>

#include "common/base/error.h"
#include "common/base/version.h"
#include "common/failure_file/failure_file.h"
#include "common/request/document.h"

namespace sleight::coordinator {
namespace {

constexpr std::string_view k_ending = ".toml";

std::string folder_in(const std::string& run_folder) {
  return run_folder + "/failures";
}

}  // namespace

FailureFiles::FailureFiles(const std::string& run_folder, std::string request_text,
                           base::FileSystem& files)
    : folder_(folder_in(run_folder)), request_text_(std::move(request_text)), files_(files) {
  if (!files_.is_directory(folder_)) return;
  std::vector<std::string> names = files_.names_in(folder_);
  std::ranges::sort(names);
  for (const std::string& name : names) {
    if (!name.ends_with(k_ending)) continue;
    Kept& kept = kept_.emplace_back();
    kept.path = folder_ + "/" + name;
    describe(kept);
  }
}

/// A file that was changed or can't be read still counts towards the maximum. It matches no
/// failure.
void FailureFiles::describe(Kept& kept) {
  kept.replica.chain = base::ChainId{UINT32_MAX};
  try {
    const auto file = failure_file::read(
        base::read_text_file(kept.path, request::k_request_bytes_max), kept.path);
    if (!file.ok()) return;
    kept.replica = file.value().replica;
    kept.scan = file.value().failed.scan;
    kept.kind = file.value().failed.failure.kind;
  } catch (const base::Error&) {
  }
}

std::string FailureFiles::path_of(const plan::ReplicaKey& replica, base::ScanIndex scan,
                                  plan::FailureKind kind) const {
  const auto found = std::ranges::find_if(kept_, [&](const Kept& kept) {
    return kept.replica == replica && kept.scan == scan && kept.kind == kind;
  });
  return found == kept_.end() ? std::string() : found->path;
}

std::optional<std::string> FailureFiles::keep(const plan::ReplicaKey& replica,
                                              const plan::FailedSimulation& failed) {
  const bool same_scan = has_last_ && replica == last_replica_ && failed.scan == last_scan_;
  nth_ = same_scan ? nth_ + 1 : 0;
  has_last_ = true;
  last_replica_ = replica;
  last_scan_ = failed.scan;

  std::string path = folder_ + "/" + failure_file::name_of(replica, failed.scan, nth_);
  if (files_.exists(path)) return path;
  if (kept_.size() >= k_failure_files_max) return std::nullopt;
  files_.make_folder(folder_);
  // Write a temporary file first. If the process is killed, no incomplete file then has the final
  // name.
  const std::string unfinished = path + ".tmp";
  base::write_text_file(files_, unfinished,
                        failure_file::to_text({.program_version = std::string(base::version()),
                                               .request_text = request_text_,
                                               .replica = replica,
                                               .failed = failed}));
  files_.rename(unfinished, path);
  kept_.push_back(
      {.replica = replica, .scan = failed.scan, .kind = failed.failure.kind, .path = path});
  return path;
}

void FailureFiles::remove_all(const std::string& run_folder, base::FileSystem& files) {
  const std::string folder = folder_in(run_folder);
  if (!files.is_directory(folder)) return;
  for (const std::string& name : files.names_in(folder))
    files.remove(folder + "/" + name);
}

}  // namespace sleight::coordinator
