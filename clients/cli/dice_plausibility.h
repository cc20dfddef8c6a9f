// How plausible dice that come to rest as is wanted are: their starts and the table under them
// beside what blind throws have.
//
// All that is random of a throw but its orientation, which is uniform, and the table's restitution
// and friction, likewise, is normal: N(0, 1) in standard scores. So one curve is the prior of every
// panel, and half the sum of the squares of so many scores less their number is by how much a log
// probability lies below the mean of blind throws' (in nats; blind throws differ among themselves
// by the square root of half that number).
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
};

/// The prior of a request's text, or what is wrong with a text that is no request for the world
/// "dice".
using DicePriorReader =
    std::function<base::Result<DicePrior, std::string>(std::string_view request_text)>;

/// What kept animations have.
struct DicePlausibility {
  /// Standard scores of one component, of all animations.
  struct Scores {
    std::string name;
    std::vector<double> scores{};
  };
  std::size_t animations = 0;
  std::vector<Scores> start{};    ///< components of one name together, whosever die they are
  std::vector<double> offsets{};  ///< control points, by bin
  double start_cost = 0;          ///< below blind throws' mean log probability, on average
  double start_spread = 0;        ///< of blind throws' log probability
  double table_cost = 0;          ///< the same of the control points that collisions hung on
  double table_spread = 0;
};

/// Of the kept animations of one chain or of all. Throws base::Error: bad_archive when the archive
/// lacks one of the variables or is damaged, environment when there is no animation, usage when
/// there is no such chain.
DicePlausibility dice_plausibility(const archive::Source& source, const DicePrior& prior,
                                   std::optional<std::uint64_t> chain);

/// A panel for the table's heights and one for each component: how often which score occurs, and
/// the prior's curve.
plot::Figure plausibility_figure(const DicePlausibility& found, const DicePrior& prior);

/// The costs in plain words, a few lines.
std::string plausibility_words(const DicePlausibility& found);

}  // namespace sleight::cli
