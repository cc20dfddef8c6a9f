// The trace of balls that spell: the thesis's figures 2.8 to 2.11.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "clients/cli/world_plots.h"

namespace sleight::world_plots {

/// How many bins to fill are filled along chains, below a line at all of them, and log p beneath;
/// over iterations.
class Spelling final : public cli::WorldPlots {
 public:
  std::string world() const override;
  std::vector<Kind> kinds() const override;
  cli::Picture draw(std::string_view what, const archive::Source& source,
                    const cli::DrawnPart& part) const override;
};

}  // namespace sleight::world_plots
