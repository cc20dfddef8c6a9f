// A picture of some animations of browsed archives.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "clients/browse/archives/browsed.h"
#include "clients/plot/figure.h"

namespace sleight::pictures {

/// Most animations of one picture.
inline constexpr std::size_t k_picked_panels_max = 24;

struct PickedPanel {
  browse::Picked picked{};
  std::string title{};
};

/// A panel for each, out of its archive's file. Throws base::Error(bad_archive) where the file
/// holds it no more. REQUIRES: at least one, of comparable scenes.
plot::Figure picked_figure(const std::string& title, const std::vector<PickedPanel>& panels);

}  // namespace sleight::pictures
