// `sleight archive info|digest|verify|export`: what people and programs ask of an archive.
//
// Archives are untrusted: each is read by a process of its own (archive/remote). Results go to
// stdout, everything else to stderr. Each function returns the program's exit code.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace sleight::cli {

/// What the archive holds, for people, or as one JSON object.
int archive_info(const std::string& path, bool json);

/// The content's SHA-256, recomputed from the values: equal for equal content.
int archive_digest(const std::string& path, bool json);

/// Checks structure, invariants and the stored digest; exit code 6 with every finding.
int archive_verify(const std::string& path, bool json);

struct ExportOptions {
  std::string path;
  std::string table = "sample_stats";
  std::string output;  ///< empty or "-": stdout
  /// Of a table of segments only these animations'; empty: all.
  std::vector<std::uint64_t> animations{};
};

/// A table as CSV.
int archive_export_csv(const ExportOptions& options);

}  // namespace sleight::cli
