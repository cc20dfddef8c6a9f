// `sleight diagnose`: whether an archive's chains have mixed.
//
// The archive is read by a process of its own (archive/remote). Results go to stdout.
#pragma once

#include <string>

#include "clients/analysis/diagnosis.h"

namespace sleight::cli {

/// Returns the exit code: not_mixed (7) with the reasons printed, or ok. Throws base::Error.
int diagnose_archive(const std::string& path, bool json, const analysis::Rules& rules);

}  // namespace sleight::cli
