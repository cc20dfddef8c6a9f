// Plots of the 2D ball: the thesis's figures 2.3 and 2.4.
//
// trace   figure 2.4: where the ball lands along chains, in diameters, with the band of the
//         tolerance, and log p below. Of one chain, or of the first six.
// paths   figure 2.3: paths of the ball's centre in some kept animations, chosen as
//         choose_animations does, with an arrow along each collision's normal and the target on the
//         table.
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
