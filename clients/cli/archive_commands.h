// `sleight archive info|digest|verify|export` and `sleight diagnose`.
//
// Archives are untrusted: a separate process reads each one (archive/remote). Results go to stdout,
// everything else to stderr. Each function returns the program's exit code.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "clients/analysis/diagnosis.h"

namespace sleight::cli {

/// Prints what the archive contains, for people or as one JSON object.
int archive_info(const std::string& path, bool json);

/// Recomputes the content's SHA-256 from the values and prints it. Equal content has equal digests.
int archive_digest(const std::string& path, bool json);

/// Checks structure, invariants and the stored digest. Prints every fault. Returns exit code 6 if
/// there is any.
int archive_verify(const std::string& path, bool json);

struct ExportOptions {
  std::string path;
  std::string table = "sample_stats";
  std::string output;  ///< empty or "-": stdout
  /// Restricts a table of segments to these animations. Empty: all animations.
  std::vector<std::uint64_t> animations{};
};

int archive_export_csv(const ExportOptions& options);

/// Checks whether the chains have mixed. Returns ok or not_mixed (7). If the chains have not mixed,
/// prints the reasons. Throws base::Error.
int diagnose_archive(const std::string& path, bool json, const analysis::Rules& rules);

}  // namespace sleight::cli
