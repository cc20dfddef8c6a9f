#include "service/coordinator/output_place.h"

#include <fmt/format.h>

#include <algorithm>

#include "common/archive/remote/remote_source.h"
#include "common/archive/summary.h"
#include "common/base/error.h"
#include "common/store/run_store.h"

namespace sleight::coordinator {

void refuse_unusable_place(const std::string& output, base::FileSystem& files) {
  if (output.empty() || output.back() == '/' || files.is_directory(output)) {
    throw base::Error(base::ExitCode::usage,
                      fmt::format("-o '{}': not a file name; use for example -o {}", output,
                                  output.empty() ? "ball.h5" : output + "/ball.h5"));
  }
  const std::string folder = base::directory_of(output);
  if (files.exists(store::RunStore::database_path(folder))) {
    throw base::Error(
        base::ExitCode::conflict,
        fmt::format("{}: the folder is the run store of another output; choose another folder",
                    output));
  }
  // Create a file that is named like the archive's temporary file. Try the longest suffix.
  const std::string trial = output + ".tmp.4194304";
  if (const auto file = files.create(trial); !file) {
    throw base::Error(fmt::format("{}: can't write the file: {}", output, file.error().message()));
  }
  files.remove(trial);
}

std::vector<std::string> beginnings_of(const request::DirectionRequest& request) {
  std::vector<std::string> beginnings{request::identity_text(request)};
  if (request.stop.found || request.stop.takes)
    beginnings.push_back(request::identity_text(request::search_of(request)));
  return beginnings;
}

void refuse_foreign_file(const std::string& output, const std::vector<std::string>& beginnings) {
  bool ours = false;
  try {
    const auto source = archive::remote::open_remote(output);
    const std::string request = archive::summary_of(*source).request_text;
    ours = std::ranges::any_of(
        beginnings, [&](const std::string& beginning) { return request.starts_with(beginning); });
  } catch (const base::Error& failure) {
    // The file may be an archive of this run, but it can't be read.
    if (failure.exit_code() == base::ExitCode::environment) throw;
  }
  if (ours) return;
  throw base::Error(base::ExitCode::conflict,
                    fmt::format("{}: not overwritten, because the file is not the archive of this "
                                "run; move it away, or choose another output",
                                output));
}

}  // namespace sleight::coordinator
