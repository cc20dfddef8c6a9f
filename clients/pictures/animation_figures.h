// Draws pictures of kept animations of any world, as in the thesis's figures 2.7 and 2.13, from the
// archive's scene description and motions.
//
// A few bodies are shown from above and, below that, from the front. Each body is drawn as its
// centre at equally spaced times, its outline at every third of these times (fading in), and the
// body at rest. Many bodies are shown from above at rest, numbered and coloured by number, beside
// eight instants from the front. Goals are tinted areas or rings.
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

/// Maximum number of bodies for which paths are drawn. If there are more bodies, they are shown at
/// several instants.
inline constexpr std::uint32_t k_ways_max = 6;

struct ShownAnimation {
  std::string title{};
  motion::Animation motion{};
  scene::Variation own{};
  std::vector<math::Vec3> offsets_m{};  ///< of the scene description's vertices
};

struct AnimationFigureOptions {
  std::optional<std::uint64_t> chain{};  ///< none: all chains
  std::size_t count = 4;                 ///< maximum animations
  /// If false, a single view in millimetres for a terminal: from above, or from the front if bodies
  /// move in that plane.
  bool whole = true;
};

/// Draws a panel per animation. REQUIRES: at least one animation; a valid scene description.
plot::Figure animation_figure(const std::string& title, const scene::Scene& scene,
                              const std::vector<ShownAnimation>& animations, bool whole = true);

/// Draws an archive's kept animations, chosen by choose_animations. Throws base::Error(bad_archive)
/// if the scene description or a motion is invalid.
plot::Figure animation_figure(const archive::Source& source, const AnimationFigureOptions& options);

}  // namespace sleight::pictures
