// `sleight export`: an archive's animations as models for other programs (.glb), or as tables.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "clients/export/keys.h"

namespace sleight::cli {

struct ExportAnimationsOptions {
  std::string path;
  std::string format = "glb";      ///< one of export_formats()
  std::vector<std::string> ids{};  ///< animation_ids.h; empty: all
  bool all = false;                ///< all, however many
  /// A file, if its name ends as the format's do; else a folder for a file each, made if missing.
  /// Empty: the table goes to stdout.
  std::string output{};
  bool together = false;             ///< .glb: all as clips of one file
  std::optional<double> fps{};       ///< .glb: keys on whole frames alone
  std::string table = "animations";  ///< .csv: one of export_tables()
  bool force = false;                ///< also over files that aren't of our making
  bool json = false;                 ///< what was written, as JSON
};

/// Without --all at most so many are written that were not named one by one.
inline constexpr std::size_t k_export_max = 100;
inline constexpr double k_export_fps_min = 0.1;
inline constexpr double k_export_fps_max = gltf::k_fps_max;

std::vector<std::string> export_formats();
std::vector<std::string> export_tables();

/// Returns the exit code; throws base::Error. Files appear whole or not at all. One that is there
/// already is replaced if it is a .glb of our making or `force` is given.
int export_animations(const ExportAnimationsOptions& options);

}  // namespace sleight::cli
