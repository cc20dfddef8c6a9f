// How plausible dice that come to rest as is wanted are: their starts and the table under them
// beside what blind throws have.
//
// All that is random of a throw but its orientation, which is uniform, and the table's restitution
// and friction, likewise, is normal: N(0, 1) in standard scores. So one curve is the prior of every
// panel, and half the sum of the squares of so many scores less their number is by how much a log
// density lies below the mean of blind throws' (in nats; single blind throws vary by the square
// root of half that number). Which control points a throw meets hangs on their heights a little; in
// some 4,000 blind throws each of three tables that moved the mean by less than 0.15.
//
// What is judged are the kept animations, unlike each other and few to a lineage, each counted
// once: also where draws have weights. Errors are those of the mean over lineages, whose animations
// hang together.
#pragma once

#include <cstddef>
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

/// A random number of a throw: a column of an archive's variable.
struct StartComponent {
  std::string variable;  ///< "start_velocity_mps"
  std::string name;      ///< for people: "velocity x"
  std::uint64_t die = 0;
  std::uint64_t axis = 0;
  double mean = 0;  ///< in the variable's unit
  double sd = 1;    ///< above 0
};

/// The prior of a request for dice.
struct DicePrior {
  std::uint64_t dice = 0;
  std::vector<StartComponent> start{};
  bool is_table_random = true;  ///< the heights of its control points
  std::size_t offset_bins = 0;  ///< of the outcome "offsets"
  double offset_first_sd = 0;   ///< where its second bin begins
  double offset_step_sd = 1;
  std::function<std::size_t(double score)> bin_of{};  ///< the world's, below offset_bins
};

/// The prior of a request's text, or what is wrong with a text that is no request for the world
/// "dice".
using DicePriorReader =
    std::function<base::Result<DicePrior, std::string>(std::string_view request_text)>;

/// By how much log densities lie below blind throws' mean.
struct PlausibilityCost {
  bool is_random = false;  ///< whether anything is
  double mean = 0;         ///< of the animations
  double error = 0;        ///< standard error of that; NaN with fewer than two lineages
  double spread = 0;       ///< standard deviation of single blind throws
};

/// What kept animations have.
struct DicePlausibility {
  /// Standard scores of one component, of all animations.
  struct Scores {
    std::string name;
    std::vector<double> scores{};
  };
  std::size_t animations = 0;
  std::size_t lineages = 0;
  bool has_weights = false;       ///< draws do, and this doesn't regard them
  std::vector<Scores> start{};    ///< components of one name together, whosever die they are
  std::vector<double> offsets{};  ///< control points, by bin
  PlausibilityCost start_cost{};
  PlausibilityCost table_cost{};  ///< of the control points that collisions hung on
  PlausibilityCost cost{};        ///< of both
};

/// Of the kept animations of one chain or of all. Throws base::Error: bad_archive when the archive
/// lacks one of the variables or is damaged, environment when there is no animation, usage when
/// there is no such chain.
DicePlausibility dice_plausibility(const archive::Source& source, const DicePrior& prior,
                                   std::optional<std::uint64_t> chain);

/// A panel for the table's heights and one for each component: how often which score occurs, and
/// the prior's curve. The outermost bars hold all beyond.
plot::Figure plausibility_figure(const DicePlausibility& found, const DicePrior& prior);

/// What the figure shows, and the costs in plain words: a few lines.
std::string plausibility_words(const DicePlausibility& found);

}  // namespace sleight::cli
