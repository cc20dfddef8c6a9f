// Selects kept animations to draw, and reads them from an archive.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/archive/kept_motions.h"
#include "common/archive/model.h"
#include "common/math/vector.h"
#include "common/motion/path.h"
#include "common/scene/scene.h"

namespace sleight::browse {

/// Returns the group whose animations are drawn: the animations of chains if there are any,
/// otherwise the search's finds. All functions below use the group that drawn_group() returns.
std::string_view drawn_group(const archive::Source& source);

/// Returns where an animation was found, such as "chain 0, scan 250" (with `step_of_draw`) or "find
/// 3 of start 5".
std::string where_found(const archive::Source& source, std::size_t animation,
                        const std::function<std::string(double draw)>& step_of_draw);

std::vector<double> of_animations(const archive::Source& source, std::string_view dataset);

/// Throws base::Error(bad_archive): "<archive>: its animation <name> <reason>". `animation` is a
/// row of the drawn group, and the row's number serves as the name.
[[noreturn]] void refuse_animation(const archive::Source& source, std::string_view name,
                                   std::string_view reason);
[[noreturn]] void refuse_animation(const archive::Source& source, std::size_t animation,
                                   std::string_view reason);

/// Returns the archive's scene description. Throws base::Error(bad_archive) if the description is
/// invalid.
scene::Scene required_scene(const archive::Source& source);

struct KeptAnimation {
  motion::Animation motion{};
  scene::Variation own{};
  std::vector<math::Vec3> offsets_m{};  ///< offsets of the scene's vertices
};
/// Reads a row of /animations or /finds. Throws base::Error(bad_archive) with `name` if the row is
/// invalid. REQUIRES: `scene` and `motions` belong to the archive, and the row exists.
KeptAnimation kept_animation(const archive::Source& source, const archive::KeptMotions& motions,
                             std::uint64_t row, const scene::Scene& scene, std::string_view name);

/// Returns up to `count` animations of one chain or of all: the first of each lineage, then the
/// others, in the archive's order. Throws base::Error with the reason if there are no animations.
/// Throws base::Error(usage) if the chain doesn't exist, or if finds are drawn, which have no
/// chains.
std::vector<std::size_t> choose_animations(const archive::Source& source,
                                           std::optional<std::uint64_t> chain, std::size_t count);

}  // namespace sleight::browse
