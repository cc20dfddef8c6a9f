// The scene of an archive, and its animations' motions: what is drawn, searched and exported.
//
// What these functions return has been checked, whoever wrote the file.
//
// Thread safety: as the source's.
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

/// Most segments of an animation that are read: some hundred times what twenty dice have.
inline constexpr std::uint64_t k_segments_max = 1'000'000;
/// Likewise of parts and of control points.
inline constexpr std::uint64_t k_own_rows_max = 1'000'000;
/// Most features, parts, vertices and triangles of a scene.
inline constexpr std::uint64_t k_scene_rows_max = 4'000'000;

/// What the archive's animations look like; or why that can't be told. Throws base::Error where it
/// can't be read.
base::Result<scene::Scene, std::string> scene_of(const Source& source);

/// The motions of /animations or /finds.
class KeptMotions {
 public:
  /// REQUIRES: scene_of gave its scene, and it has the group.
  KeptMotions(const Source& source, std::string_view group);

  std::uint64_t count() const { return count_; }
  /// Of one animation; or why it is none. Throws what the source throws.
  /// REQUIRES: nth < count(); the archive's scene.
  base::Result<motion::Animation, std::string> animation(std::uint64_t nth,
                                                         const scene::Scene& scene) const;
  /// What of the scene is its own; likewise.
  base::Result<scene::Variation, std::string> variation(std::uint64_t nth,
                                                        const scene::Scene& scene) const;
  /// The offsets of the scene's vertices, by row; empty where there are none.
  std::vector<math::Vec3> offsets_m(std::uint64_t nth, const scene::Scene& scene) const;
  bool in_proportion(std::uint64_t nth) const;

 private:
  struct Rows {
    std::uint64_t first = 0;
    std::uint64_t count = 0;
  };
  base::Result<Rows, std::string> rows(std::uint64_t nth, const std::string& dim,
                                       std::uint64_t most) const;
  /// Rows of a table (tables.h), up to the first with a number out of its field's range.
  template <const auto& fields>
  auto records(const Rows& rows) const;
  template <class Element>
  std::vector<Element> column(std::string_view name, const Rows& rows, std::uint64_t width) const;

  const Source& source_;
  std::string group_;
  std::uint64_t count_ = 0;
};

}  // namespace sleight::archive
