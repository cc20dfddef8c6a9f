// `sleight diagnose`: whether an archive's chains have mixed. A separate process reads the archive
// (archive/remote). Results go to stdout.
#pragma once

#include <string>

#include "clients/analysis/diagnosis.h"

namespace sleight::cli {

/// Returns ok or not_mixed (7). If the chains have not mixed, prints the reasons. Throws
/// base::Error.
int diagnose_archive(const std::string& path, bool json, const analysis::Rules& rules);

}  // namespace sleight::cli
