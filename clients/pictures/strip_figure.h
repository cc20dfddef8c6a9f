// Draws an animation as a strip: the bodies at equally spaced times, from above and from the front.
// Thread safety: a pure function.
#pragma once

#include <string>

#include "clients/pictures/animation_figures.h"
#include "clients/plot/figure.h"
#include "common/scene/scene.h"

namespace sleight::pictures {

/// Number of pictures in a strip.
inline constexpr std::size_t k_strip_pictures = 8;

/// `end_s`: time of the last picture. REQUIRES: a valid scene description.
plot::Figure strip_figure(const std::string& title, const scene::Scene& scene,
                          const ShownAnimation& animation, double end_s);

}  // namespace sleight::pictures
