// Reads an archive's scene and the motions of its animations, for display, search and export.
//
// All returned values have been checked, so the file may be hostile.
//
// Thread safety: as the source.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "common/archive/model.h"
#include "common/base/result.h"
#include "common/motion/path.h"
#include "common/scene/scene.h"

namespace sleight::archive {

/// Maximum segments of an animation. A throw of twenty dice has about a hundredth of this number of
/// segments.
inline constexpr std::uint64_t k_segments_max = 1'000'000;
/// Maximum parts of an animation; also its maximum control points.
inline constexpr std::uint64_t k_own_rows_max = 1'000'000;
/// Maximum features, parts, vertices or triangles of a scene.
inline constexpr std::uint64_t k_scene_rows_max = 4'000'000;

/// Returns the archive's scene, or the reason why the scene is invalid. Throws base::Error if the
/// archive can't be read.
base::Result<scene::Scene, std::string> scene_of(const Source& source);

class KeptMotions {
 public:
  /// REQUIRES: scene_of returned the scene, and the group exists.
  KeptMotions(const Source& source, std::string_view group);

  std::uint64_t count() const { return count_; }
  /// Returns an animation, or the reason why the animation is invalid. Throws what the source
  /// throws. REQUIRES: nth < count(); `scene` is the archive's.
  base::Result<motion::Animation, std::string> animation(std::uint64_t nth,
                                                         const scene::Scene& scene) const;
  /// Returns the parts of the scene that only this animation has. Errors as animation().
  base::Result<scene::Variation, std::string> variation(std::uint64_t nth,
                                                        const scene::Scene& scene) const;
  /// Returns offsets of the scene's vertices, by row. Empty: no offsets.
  std::vector<math::Vec3> offsets_m(std::uint64_t nth, const scene::Scene& scene) const;
  bool in_proportion(std::uint64_t nth) const;

 private:
  struct Rows {
    std::uint64_t first = 0;
    std::uint64_t count = 0;
  };
  base::Result<Rows, std::string> rows(std::uint64_t nth, const std::string& dim,
                                       std::uint64_t most) const;
  /// Reads rows of a table (tables.h). Stops before the first row that has a value out of range.
  template <const auto& fields>
  auto records(const Rows& rows) const;
  template <class Element>
  std::vector<Element> column(std::string_view name, const Rows& rows, std::uint64_t width) const;

  const Source& source_;
  std::string group_;
  std::uint64_t count_ = 0;
};

}  // namespace sleight::archive
