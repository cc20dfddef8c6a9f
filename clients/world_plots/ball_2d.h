// Plots of the 2D ball: the thesis's figures 2.3 and 2.4.
//
//   `trace` is figure 2.4: landing places along chains in diameters, with the tolerance as a
//     band, and log p below. The plot shows one chain or the first six.
//   `paths` is figure 2.3: paths of the ball's centre in some kept animations (choose_animations),
//     with an arrow along each collision's normal and the target on the table.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "clients/pictures/world_plots.h"

namespace sleight::world_plots {

class Ball2d final : public pictures::WorldPlots {
 public:
  std::string world() const override;
  std::vector<Kind> kinds() const override;
  pictures::Picture draw(std::string_view what, const archive::Source& source,
                         const pictures::DrawnPart& part) const override;
};

}  // namespace sleight::world_plots
