// `sleight export`: writes an archive's animations as tables, pictures, films, or models for other
// programs (.glb).
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "clients/browse/archives/animation_ids.h"
#include "clients/browse/archives/index_cache.h"
#include "clients/export/keys.h"
#include "common/archive/model.h"

namespace sleight::cli {

/// Maximum animations written if neither `all` nor ids are given.
inline constexpr std::size_t k_export_max = 100;

/// Ids, or queries with representatives. Default: all animations.
struct ExportChoice {
  std::vector<std::string> ids{};     ///< animation_ids.h
  std::vector<std::string> select{};  ///< queries (browse/query.h) that must all hold
  /// Maximum number of groups of similar animations (browse/groups.h). One animation per group is
  /// exported.
  std::optional<std::size_t> representatives{};
  bool all = false;  ///< no maximum
  /// State of the archive's file before it was opened. For index_cache.h. None: no cache.
  std::optional<browse::FileState> file{};
};

/// Returns at least one animation. Animations are in the order of the given ids, otherwise in the
/// archive's order. Representatives of larger groups come first. Throws base::Error(usage) if a
/// query is invalid (with its position), if nothing matches, or if `is_bounded` and more than
/// k_export_max animations match.
std::vector<browse::AnimationId> chosen(const archive::Source& source, const ExportChoice& choice,
                                        bool is_bounded);

struct ExportAnimationsOptions {
  std::string path;
  std::string format{};  ///< one of export_formats(); empty: the output's extension, or glb
  ExportChoice choice{};
  /// A file's path if the name has the format's extension, otherwise a folder's path. The folder
  /// gets one file per animation (png: one folder per animation) and is created if missing. Empty:
  /// tables go to stdout.
  std::string output{};
  bool together = false;             ///< .glb: all animations as clips of one file
  std::optional<double> fps{};       ///< .glb: keys on whole frames only; films: default k_film_fps
  std::string view = "both";         ///< films: one of export_views()
  double scale = 1;                  ///< films: multiplies the size of 1280 x 720 pixels
  std::string table = "animations";  ///< .csv: one of export_tables()
  bool force = false;                ///< replaces files that sleight didn't make
  bool json = false;                 ///< prints what was written as JSON
};

inline constexpr double k_film_fps = 24;
inline constexpr double k_film_scale_max = 8;
inline constexpr double k_export_fps_min = 0.1;
inline constexpr double k_export_fps_max = gltf::k_fps_max;

std::vector<std::string> export_formats();
std::vector<std::string> export_tables();
std::vector<std::string> export_views();

/// Returns the exit code. Throws base::Error. Files appear complete or not at all. Replaces an
/// existing file only if sleight made it (.glb) or if `force` is set.
int export_animations(const ExportAnimationsOptions& options);

}  // namespace sleight::cli
