// Pictures of the archives of balls that spell: the thesis's figures 2.7 to 2.11.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "clients/plot/figure.h"
#include "common/archive/model.h"
#include "common/base/result.h"

namespace sleight::cli {

/// The box of bins that a spelling request describes. Lengths in millimetres.
struct SpellingBox {
  std::uint32_t columns = 0;
  std::uint32_t rows = 0;
  std::vector<bool> designated = {};  ///< row by row from the back, the top of the picture
  double bin_mm = 0;
  double partition_mm = 0;
  double partition_height_mm = 0;
  double box_height_mm = 0;
  double drop_height_mm = 0;  ///< of a ball's lowest point
  double ball_diameter_mm = 0;

  std::uint64_t designated_count() const;
};

/// The box of a request's text, or what is wrong with a text that is no request for the world
/// "spelling". Words become bins by the world's own fonts, so a program's main, where the sides are
/// joined, gives this function.
using SpellingBoxReader =
    std::function<base::Result<SpellingBox, std::string>(std::string_view request_text)>;

struct SpellingAnimationOptions {
  std::optional<std::uint64_t> chain{};  ///< none: of all chains
  std::size_t count = 4;                 ///< at most so many animations
  bool frames = true;                    ///< without: the views from above alone
};

/// Figure 2.7, a panel for each kept animation, chosen as choose_animations does: the box from
/// above with all balls at rest, bins to be filled tinted, balls numbered and coloured in the order
/// of their drops; beside it eight instants from the front, the first drop to rest.
plot::Figure spelling_animations(const archive::Source& source, const SpellingBox& box,
                                 const SpellingAnimationOptions& options);

/// Figures 2.8 to 2.11: how many designated bins are filled along chains, and log p below, over
/// iterations. Of one chain, or of the first six when none is given.
plot::Figure spelling_trace(const archive::Source& source, const SpellingBox& box,
                            std::optional<std::uint64_t> chain, std::uint64_t draws);

}  // namespace sleight::cli
