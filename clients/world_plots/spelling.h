// The trace of balls that spell, as in the thesis's figures 2.8 to 2.11.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "clients/pictures/world_plots.h"

namespace sleight::world_plots {

/// Draws two plots over iterations: the number of filled bins, with a line at the number of
/// designated bins; and below it, log p.
class Spelling final : public pictures::WorldPlots {
 public:
  std::string world() const override;
  std::vector<Kind> kinds() const override;
  pictures::Picture draw(std::string_view what, const archive::Source& source,
                         const pictures::DrawnPart& part) const override;
};

}  // namespace sleight::world_plots
