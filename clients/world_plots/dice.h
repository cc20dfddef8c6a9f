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
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "clients/pictures/world_plots.h"
#include "clients/plot/figure.h"
#include "common/archive/model.h"

namespace sleight::world_plots {

/// Bins of the outcome `offsets`, by a control point's height in standard deviations: below the
/// first edge, in steps from there, above the last. Its long_name says the same.
inline constexpr std::size_t k_offset_bins = 14;
inline constexpr double k_offset_first_sd = -3;
inline constexpr double k_offset_step_sd = 0.5;
std::size_t offset_bin_of(double score);

/// A random number of a throw: a column of an archive's variable.
struct StartComponent {
  std::string variable;  ///< "start_velocity_mps"
  std::string name;      ///< for people: "velocity x"
  std::uint64_t die = 0;
  std::uint64_t axis = 0;
  double mean = 0;  ///< in the variable's unit
  double sd = 1;    ///< above 0
};

/// What blind throws have.
struct DicePrior {
  std::uint64_t dice = 0;
  std::vector<StartComponent> start{};
  bool is_table_random = true;  ///< the heights of its control points
};

/// From /prior and /sample_stats_prior. Throws base::Error(bad_archive) when it is damaged.
DicePrior dice_prior_of(const archive::Source& source);

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
/// there is no such chain, or all animations were found by search.
DicePlausibility dice_plausibility(const archive::Source& source, const DicePrior& prior,
                                   std::optional<std::uint64_t> chain);

/// A panel for the table's heights and one for each component: how often which score occurs, and
/// the prior's curve. The outermost bars hold all beyond.
plot::Figure plausibility_figure(const DicePlausibility& found, const DicePrior& prior);

/// What the figure shows, and the costs in plain words: a few lines.
std::string plausibility_words(const DicePlausibility& found);

/// `plausibility`: these.
class Dice final : public pictures::WorldPlots {
 public:
  std::string world() const override;
  std::vector<Kind> kinds() const override;
  pictures::Picture draw(std::string_view what, const archive::Source& source,
                         const pictures::DrawnPart& part) const override;
};

}  // namespace sleight::world_plots
