// Draws a picture of selected animations of browsed archives.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "clients/browse/archives/browsed.h"
#include "clients/plot/figure.h"

namespace sleight::pictures {

inline constexpr std::size_t k_picked_panels_max = 24;

struct PickedPanel {
  browse::Picked picked{};
  std::string title{};
};

/// Draws a panel per animation, read from its archive's file. Throws base::Error(bad_archive) if
/// the file doesn't contain the animation any more. REQUIRES: at least one panel, comparable
/// scenes.
plot::Figure picked_figure(const std::string& title, const std::vector<PickedPanel>& panels);

}  // namespace sleight::pictures
