// Defines how archives name a world's states and outcomes, and how their bytes are read.
//
// The archive and the services treat states as opaque bytes. Each world (worker/worlds) provides a
// WorldLayout and a StateReader; a program's main function connects the two sides.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "common/base/bytes.h"
#include "common/motion/segment.h"
#include "common/scene/scene.h"

namespace sleight::archive {

/// Maximum bytes of one of Dimension::names.
inline constexpr std::size_t k_index_name_bytes_max = 512;

struct Dimension {
  std::string name;  ///< such as "collision"; one size per name within a group
  std::size_t size = 0;
  /// In a WorldLayout: the dimension's coordinate, one distinct name per index. A name has 1 to
  /// k_index_name_bytes_max bytes of UTF-8 without control characters. Empty: the coordinate is 0,
  /// 1, ... Unused in a DatasetSpec, whose coordinate is a dataset (model.h).
  std::vector<std::string> names = {};
};

/// A named array of doubles.
struct Variable {
  std::string name;                  ///< with unit as suffix, such as "normal_rad"
  std::vector<Dimension> dims = {};  ///< empty for a scalar
  std::string unit = "1";            ///< "rad", "m", "1" for a pure number
  std::string meaning;               ///< one sentence, for `long_name`
  /// For each element of a state's variable: mean and standard deviation under the normal prior.
  /// NaN: the element is not normally distributed. A standard deviation of 0: the element is fixed.
  /// Empty: no element is normally distributed.
  std::vector<double> prior_mean = {};
  std::vector<double> prior_sd = {};
  std::size_t size() const {
    std::size_t product = 1;
    for (const Dimension& dim : dims)
      product *= dim.size;
    return product;
  }
};

struct WorldLayout {
  std::string world;                        ///< "ball_2d"
  std::vector<Variable> variables;          ///< of the state
  std::vector<Variable> outcomes;           ///< of each scan
  std::vector<std::string> proposal_kinds;  ///< at least one
  /// One line that users of the samples must read; empty: no warning. Programs print the warning
  /// when a run starts, and the archive stores it.
  std::string warning = {};
  /// Logarithm of a ratio: P(satisfied) under the prior, divided by P(satisfied) of natural throws,
  /// which a person could make blindly. The value is below 0 if only some draws are natural throws,
  /// and all satisfying draws are among them. For example, it is the log of the probability that a
  /// draw drops all balls. The value is above 0 if a draw stands for several equally likely
  /// throws, and one satisfying throw among them is enough. This is so for dice whose faces are
  /// numbered afterwards.
  double log_natural_throw = 0;
};

/// Maximum elements of a variable whose prior draws are stored. Larger variables are omitted,
/// because their distribution is known; an example is a thousand normal offsets.
inline constexpr std::size_t k_prior_elements_max = 64;
std::vector<Variable> prior_variables(const WorldLayout& layout);
/// Selects the values of prior_variables from the values of all variables.
std::vector<double> prior_values(const WorldLayout& layout, std::span<const double> values);

/// Whether a motion ends as its outcome predicted.
enum class PlaysOut : std::uint8_t {
  yes,
  otherwise,  ///< takes too long to come to rest
  failed      ///< the simulator can't complete the motion
};

/// The motion of a satisfied state. The motion is simulated to its end even if the outcome was
/// decided early.
struct Motion {
  PlaysOut ends = PlaysOut::yes;
  /// The segments of all bodies. A body's segments are in order of time; bodies are in any order.
  /// Empty unless `ends` is yes.
  std::vector<motion::Segment> segments{};
};

/// Reads the opaque bytes of states. All states belong to one world and one request. Thread-safe.
/// REQUIRES, for every function: this world's worker produced `state`.
class StateReader {
 public:
  virtual ~StateReader() = default;
  virtual const WorldLayout& layout() const = 0;
  /// Returns the values of all variables in layout order, each row-major.
  virtual std::vector<double> variables(base::BytesView state) const = 0;
  /// Returns numbers for comparing animations. The numbers' meaning depends on the world. The call
  /// may need a simulation, and the result may have some kilobytes.
  virtual std::vector<double> likeness(base::BytesView state) const = 0;
  /// Returns how different two animations look, in the unit that the world states. Equal animations
  /// give 0. REQUIRES: results of likeness().
  virtual double likeness_distance(std::span<const double> a, std::span<const double> b) const = 0;
  /// Returns whether likeness_distance > `distance`. May be cheaper than likeness_distance.
  virtual bool is_unlike(std::span<const double> a, std::span<const double> b,
                         double distance) const {
    return likeness_distance(a, b) > distance;
  }
  /// Returns the motion of a state. Only states with `ends` equal to `yes` are kept as animations.
  virtual Motion play(base::BytesView state) const = 0;
  /// Returns the scene shared by all animations of the run.
  virtual const scene::Scene& scene() const = 0;
  /// Returns the animation's own parts of the scene. REQUIRES: `segments` are the state's motion.
  virtual scene::Variation variation(base::BytesView /*state*/,
                                     std::span<const motion::Segment> /*segments*/) const {
    return {};
  }
  /// Returns the values of prior_variables in the nth draw from the prior. Simulates nothing: the
  /// run's workers simulate the draw (RunView::for_each_prior_draw).
  virtual std::vector<double> prior_draw(std::uint64_t nth) const = 0;
  /// Returns log p_w of `count` blind throws, such as a person would make. A find's log p_w is
  /// compared with these values. Each call returns the values of the same throws.
  virtual std::vector<double> log_priors_of_throws(std::size_t /*count*/) const { return {}; }
};

}  // namespace sleight::archive
