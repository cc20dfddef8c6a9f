// `sleight export`: an archive's animations as models for other programs (.glb), as tables, and as
// pictures and films.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "clients/cli/export_choice.h"
#include "clients/export/keys.h"

namespace sleight::cli {

struct ExportAnimationsOptions {
  std::string path;
  std::string format{};  ///< one of export_formats(); empty: the output's ending, or glb
  ExportChoice choice{};
  /// A file, if its name ends as the format's do; else a folder for a file each (of png a folder
  /// each), made if missing. Empty: the table goes to stdout.
  std::string output{};
  bool together = false;        ///< .glb: all as clips of one file
  std::optional<double> fps{};  ///< .glb: keys on whole frames alone; films: k_film_fps if none
  std::string view = "both";    ///< of films: one of export_views()
  double scale = 1;             ///< of films: pixels to one of 1280 x 720
  std::string table = "animations";  ///< .csv: one of export_tables()
  bool force = false;                ///< also over files that aren't of our making
  bool json = false;                 ///< what was written, as JSON
};

inline constexpr double k_film_fps = 24;
inline constexpr double k_film_scale_max = 8;
inline constexpr double k_export_fps_min = 0.1;
inline constexpr double k_export_fps_max = gltf::k_fps_max;

std::vector<std::string> export_formats();
std::vector<std::string> export_tables();
std::vector<std::string> export_views();

/// Returns the exit code; throws base::Error. Files appear whole or not at all. One that is there
/// already is replaced if it is a .glb of our making or `force` is given.
int export_animations(const ExportAnimationsOptions& options);

}  // namespace sleight::cli
