// Exports animations as pictures and films (animation_frames.h).
#pragma once

#include <cstddef>
#include <functional>
#include <string>

#include "clients/browse/archives/animation_ids.h"
#include "clients/cli/exported_files.h"
#include "common/archive/model.h"
#include "common/scene/scene.h"

namespace sleight::cli {

struct FilmOptions {
  std::string format = "mp4";  ///< png: a folder of frames; svg: one picture; or mp4
  double fps = 24;
  std::string view = "both";  ///< both, above or front
  double scale = 1;
};

class FilmExport {
 public:
  /// Throws base::Error(bad_archive) if the scene description is invalid.
  FilmExport(const archive::Source& source, FilmOptions options);

  /// Writes the file at `place` completely or not at all. `progress`: finished frames, total
  /// frames.
  WrittenFile write(const browse::AnimationId& id, const std::string& place,
                    const std::function<void(std::size_t, std::size_t)>& progress) const;

 private:
  const archive::Source& source_;
  FilmOptions options_;
  scene::Scene scene_;
};

}  // namespace sleight::cli
