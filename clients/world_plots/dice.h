// Plots how plausible the dice's solutions are: their starts and the table below them, compared
// with blind throws.
//
// A throw's random numbers are normal, N(0, 1) as standard scores, except the orientation and the
// table's restitution and friction, which are uniform. So each panel has the same prior curve. A
// throw's log density, minus the mean of blind throws, is half of (the number of scores minus the
// sum of their squares), in nats. For single blind throws, the standard deviation of this
// difference is the square root of half the number of scores. The control points that a throw meets
// depend slightly on their heights. In about 4,000 blind throws on each of three tables, this
// dependence moved the mean by less than 0.15.
//
// The plot uses the kept animations, which differ from each other and are few per lineage. Each
// animation counts once, even if draws have weights. Animations within a lineage are dependent, so
// the mean's error treats only different lineages as independent.
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

/// Bins of the outcome `offsets`, by a control point's height in standard deviations. The outermost
/// bins are unbounded; the others have equal widths. The outcome's long_name describes the bins.
inline constexpr std::size_t k_offset_bins = 14;
inline constexpr double k_offset_first_sd = -3;
inline constexpr double k_offset_step_sd = 0.5;
std::size_t offset_bin_of(double score);

/// One of the random numbers of a throw. In the archive, it is a column of a variable.
struct StartComponent {
  std::string variable;  ///< such as "start_velocity_mps"
  std::string name;      ///< for people, such as "velocity x"
  std::uint64_t die = 0;
  std::uint64_t axis = 0;
  double mean = 0;  ///< in the variable's unit
  double sd = 1;    ///< above 0
};

/// The prior of throws.
struct DicePrior {
  std::uint64_t dice = 0;
  std::vector<StartComponent> start{};
  bool is_table_random = true;  ///< whether control points have random heights
};

/// Reads /prior and /sample_stats_prior. Throws base::Error(bad_archive) if these groups are
/// damaged.
DicePrior dice_prior_of(const archive::Source& source);

/// How far log densities are below the mean of blind throws.
struct PlausibilityCost {
  bool is_random = false;  ///< whether anything is random
  double mean = 0;         ///< of the animations
  double error = 0;        ///< standard error of the mean; NaN with fewer than two lineages
  double spread = 0;       ///< standard deviation of single blind throws
};

/// The plausibility of kept animations.
struct DicePlausibility {
  /// Standard scores of one component in all animations.
  struct Scores {
    std::string name;
    std::vector<double> scores{};
  };
  std::size_t animations = 0;
  std::size_t lineages = 0;
  bool has_weights = false;       ///< whether draws have weights, which are ignored here
  std::vector<Scores> start{};    ///< components with the same name together, for all dice
  std::vector<double> offsets{};  ///< control points, by bin
  PlausibilityCost start_cost{};
  PlausibilityCost table_cost{};  ///< control points that influenced collisions
  PlausibilityCost cost{};        ///< start and table
};

/// Analyses the kept animations of one chain or of all. Throws base::Error: bad_archive if a
/// variable is missing or damaged, environment if there is no animation, usage if there is no such
/// chain or all animations are finds.
DicePlausibility dice_plausibility(const archive::Source& source, const DicePrior& prior,
                                   std::optional<std::uint64_t> chain);

/// Draws one panel for the table's heights and one for each component. A panel shows a histogram of
/// scores and the prior's curve. The outermost bars include all values beyond them.
plot::Figure plausibility_figure(const DicePlausibility& found, const DicePrior& prior);

/// Returns a few lines that explain the figure and the costs.
std::string plausibility_words(const DicePlausibility& found);

/// The kind `plausibility`.
class Dice final : public pictures::WorldPlots {
 public:
  std::string world() const override;
  std::vector<Kind> kinds() const override;
  pictures::Picture draw(std::string_view what, const archive::Source& source,
                         const pictures::DrawnPart& part) const override;
};

}  // namespace sleight::world_plots
