// Pictures of kept animations of any world, by the scene and the motions that their archive holds:
// the thesis's figures 2.7 and 2.13.
//
// Few bodies: the scene from above and, beneath, from the front. Of each body its centre at equal
// times, its outline at each third of them, fading in, and the body where it comes to rest. Many:
// the scene from above at rest, bodies numbered and coloured in the order of their numbers, and
// beside it eight instants from the front. Wanted places are tinted, or rings.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "clients/plot/figure.h"
#include "common/archive/model.h"
#include "common/motion/path.h"
#include "common/scene/scene.h"

namespace sleight::pictures {

/// More bodies are shown at instants instead of by their ways.
inline constexpr std::uint32_t k_ways_max = 6;

/// What one panel shows.
struct ShownAnimation {
  std::string title{};
  motion::Animation motion{};
  scene::Variation own{};
  std::vector<math::Vec3> offsets_m{};  ///< of the scene's vertices
};

struct AnimationFigureOptions {
  std::optional<std::uint64_t> chain{};  ///< none: of all chains
  std::size_t count = 4;                 ///< at most so many animations
  /// Without: one view alone, in millimetres, for a terminal's few dots: from above, or from the
  /// front where that is where things move.
  bool whole = true;
};

/// A panel for each animation. REQUIRES: an animation at least; a sound scene.
plot::Figure animation_figure(const std::string& title, const scene::Scene& scene,
                              const std::vector<ShownAnimation>& animations, bool whole = true);

/// The same of an archive's kept animations, chosen as choose_animations does. Throws
/// base::Error(bad_archive) on what can be no scene or no motion.
plot::Figure animation_figure(const archive::Source& source, const AnimationFigureOptions& options);

}  // namespace sleight::pictures
