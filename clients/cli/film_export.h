// Animations of an archive as pictures and films (animation_frames.h).
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
  std::string format = "mp4";  ///< png: a folder of frames; svg: one picture; mp4
  double fps = 24;
  std::string view = "both";  ///< or above, front
  double scale = 1;
};

class FilmExport {
 public:
  /// Throws base::Error(bad_archive) where its scene can be none.
  FilmExport(const archive::Source& source, FilmOptions options);

  /// At this place, whole or not at all. `progress`: frames that are done, of how many.
  WrittenFile write(const browse::AnimationId& id, const std::string& place,
                    const std::function<void(std::size_t, std::size_t)>& progress) const;

 private:
  const archive::Source& source_;
  FilmOptions options_;
  scene::Scene scene_;
};

}  // namespace sleight::cli
