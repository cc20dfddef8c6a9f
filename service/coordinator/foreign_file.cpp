#include "service/coordinator/foreign_file.h"

#include <fmt/format.h>

#include <algorithm>

#include "common/archive/hdf5/guarded.h"
#include "common/archive/hdf5/reader.h"
#include "common/archive/summary.h"
#include "common/base/error.h"

namespace sleight::coordinator {

void refuse_foreign_file(const std::string& output, const std::vector<std::string>& beginnings) {
  bool ours = false;
  try {
    ours = archive::hdf5::guarded(output, {}, [&] {
             const auto source = archive::hdf5::open_file(output);
             const std::string request = archive::summary_of(*source).request_text;
             return std::ranges::any_of(beginnings,
                                        [&](const std::string& beginning) {
                                          return request.starts_with(beginning);
                                        })
                        ? 0
                        : 1;
           }) == 0;
  } catch (const base::Error& failure) {
    if (failure.exit_code() == base::ExitCode::interrupted) throw;
  }
  if (ours) return;
  throw base::Error(base::ExitCode::conflict,
                    fmt::format("{}: is not the archive of this run, so it is not overwritten; "
                                "move it away, or choose another output",
                                output));
}

}  // namespace sleight::coordinator
