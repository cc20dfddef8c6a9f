// Which of an archive's kept animations to draw, and where their motions lie.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "clients/analysis/archive_rows.h"
#include "common/archive/kept_motions.h"
#include "common/archive/model.h"
#include "common/math/vector.h"
#include "common/motion/path.h"
#include "common/scene/scene.h"

namespace sleight::browse {

/// The group whose animations are drawn: those of chains; those of a search where no chain has any.
/// All functions below are of this group.
std::string_view drawn_group(const archive::Source& source);

/// Where an animation was found: "chain 0, scan 250" by `step_of_draw`, or "find 3 of start 5".
std::string where_found(const archive::Source& source, std::size_t animation,
                        const std::function<std::string(double draw)>& step_of_draw);

/// One number of each kept animation.
std::vector<double> of_animations(const archive::Source& source, std::string_view dataset);

/// Throws base::Error(bad_archive): "<archive>: its animation <name> <reason>". Of a row of the
/// drawn group its number is the name.
[[noreturn]] void refuse_animation(const archive::Source& source, std::string_view name,
                                   std::string_view reason);
[[noreturn]] void refuse_animation(const archive::Source& source, std::size_t animation,
                                   std::string_view reason);

/// What all animations look like. Throws base::Error(bad_archive) where it can be none.
scene::Scene required_scene(const archive::Source& source);

/// An animation as its archive keeps it.
struct KeptAnimation {
  motion::Animation motion{};
  scene::Variation own{};
  std::vector<math::Vec3> offsets_m{};  ///< of the scene's vertices
};
/// One of /animations or /finds. Throws base::Error(bad_archive) that calls it by the name, where
/// it is none. REQUIRES: the archive's scene and motions, a row of these.
KeptAnimation kept_animation(const archive::Source& source, const archive::KeptMotions& motions,
                             std::uint64_t row, const scene::Scene& scene, std::string_view name);

/// Up to `count` animations, of one chain or of all: the first of each lineage, then the others, in
/// the archive's order. Throws base::Error that says why when there is none, usage when there is no
/// such chain, or finds are drawn, which have none.
std::vector<std::size_t> choose_animations(const archive::Source& source,
                                           std::optional<std::uint64_t> chain, std::size_t count);

}  // namespace sleight::browse
