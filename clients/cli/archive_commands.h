// `sleight archive info|digest|verify|export`.
//
// Archives are untrusted: a separate process reads each one (archive/remote). Results go to stdout,
// everything else to stderr. Each function returns the program's exit code.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace sleight::cli {

/// Prints the archive's content for people, or as one JSON object.
int archive_info(const std::string& path, bool json);

/// Prints the content's SHA-256, recomputed from the values. Equal content has equal digests.
int archive_digest(const std::string& path, bool json);

/// Checks structure, invariants and the stored digest. Prints every finding and returns exit code 6
/// if there are any.
int archive_verify(const std::string& path, bool json);

struct ExportOptions {
  std::string path;
  std::string table = "sample_stats";
  std::string output;  ///< empty or "-": stdout
  /// Restricts a table of segments to these animations; empty: all.
  std::vector<std::uint64_t> animations{};
};

int archive_export_csv(const ExportOptions& options);

}  // namespace sleight::cli
