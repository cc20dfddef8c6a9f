// Reads the scene of an archive and its animations' motions, for display, search and export.
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

/// Maximum segments of an animation: about a hundred times as many as a throw of twenty dice has.
inline constexpr std::uint64_t k_segments_max = 1'000'000;
/// Maximum parts, and maximum control points, of an animation.
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
  /// Returns the parts of the scene specific to the animation. Errors as animation().
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
  /// Reads rows of a table (tables.h), up to the first row with a value out of range.
  template <const auto& fields>
  auto records(const Rows& rows) const;
  template <class Element>
  std::vector<Element> column(std::string_view name, const Rows& rows, std::uint64_t width) const;

  const Source& source_;
  std::string group_;
  std::uint64_t count_ = 0;
};

}  // namespace sleight::archive
