// Draws animations as strips: each strip shows the bodies at equally spaced times, from above and
// from the front, from the first start to the end.
// Thread safety: pure functions.
#pragma once

#include <string>
#include <vector>

#include "clients/pictures/animation_figures.h"
#include "clients/plot/figure.h"
#include "common/scene/scene.h"

namespace sleight::pictures {

/// Number of pictures in a strip.
inline constexpr std::size_t k_strip_pictures = 8;

/// Draws one panel per animation. `end_s`: time of the last picture. REQUIRES: at least one
/// animation; a valid scene description.
plot::Figure strip_figure(const std::string& title, const scene::Scene& scene,
                          const std::vector<ShownAnimation>& animations, double end_s);

}  // namespace sleight::pictures
