// How a world's states and outcomes are named in archives, and how their bytes are
// read.
//
// The archive and the services treat states as opaque bytes; a world (worker/worlds) gives this
// description and one StateReader, and a program's main joins the two.
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

struct Dimension {
  std::string name;  ///< e.g. "collision"; one name has one size within a group
  std::size_t size = 0;
};

/// A named array of doubles.
struct Variable {
  std::string name;             ///< with its unit as suffix, e.g. "normal_rad"
  std::vector<Dimension> dims;  ///< none for a scalar
  std::string unit;             ///< "rad", "m", "1" for a pure number
  std::string meaning;          ///< one sentence, for `long_name`
  /// Of a state's variable: its components' normal distributions under the prior, one for each
  /// element; of a component that is not normal NaN, of one that is fixed 0. Empty: none is.
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
  /// One line that a user of the samples must know; empty: none. Programs print it when a run
  /// starts, and its archive carries it.
  std::string warning = {};
  /// P(satisfied) of draws from the prior, divided by e to this, is that of natural throws, which a
  /// person could make blindly. Below 0 where only some draws are such throws, and all that satisfy
  /// are among them: the log of the probability that a draw has all balls in it. Above 0 where a
  /// draw satisfies as soon as one of several equally likely throws that it stands for does: dice
  /// whose faces are numbered afterwards.
  double log_natural_throw = 0;
};

/// Of a state's variables those whose values prior draws hold: not large ones of which the
/// distribution says all, such as a thousand normal offsets.
inline constexpr std::size_t k_prior_elements_max = 64;
std::vector<Variable> prior_variables(const WorldLayout& layout);
/// Of the values of all variables theirs.
std::vector<double> prior_values(const WorldLayout& layout, std::span<const double> values);

/// Whether a motion ends as the outcome said.
enum class PlaysOut : std::uint8_t {
  yes,
  otherwise,  ///< it takes too long to come to rest
  failed      ///< the simulator can't carry it out
};

/// The whole motion of a satisfying state, simulated to its end: it was perhaps decided early.
struct Motion {
  PlaysOut ends = PlaysOut::yes;
  /// Of each body in the order of time, bodies in any order; none unless it plays out.
  std::vector<motion::Segment> segments{};
};

/// Reads the opaque state bytes of one world with one request. Thread-safe.
/// REQUIRES of every function: `state` came from this world's worker (a run store is ours).
class StateReader {
 public:
  virtual ~StateReader() = default;
  virtual const WorldLayout& layout() const = 0;
  /// The values of all variables, in layout order, row-major each.
  virtual std::vector<double> variables(base::BytesView state) const = 0;
  /// What of an animation is compared with others: numbers whose meaning is the world's own. They
  /// may take a simulation, and some kilobytes.
  virtual std::vector<double> likeness(base::BytesView state) const = 0;
  /// How unlike two animations look, in the world's own stated unit: 0 for equal ones. REQUIRES:
  /// what likeness() gave of them.
  virtual double likeness_distance(std::span<const double> a, std::span<const double> b) const = 0;
  /// Whether that is above `distance`, which may be seen sooner than how far above.
  virtual bool is_unlike(std::span<const double> a, std::span<const double> b,
                         double distance) const {
    return likeness_distance(a, b) > distance;
  }
  /// The motion of a state. Only states that play out are kept as animations.
  virtual Motion play(base::BytesView state) const = 0;
  /// What the run's animations look like; the same for each.
  virtual const scene::Scene& scene() const = 0;
  /// What of that is the animation's own. REQUIRES: the segments of that state's motion.
  virtual scene::Variation variation(base::BytesView /*state*/,
                                     std::span<const motion::Segment> /*segments*/) const {
    return {};
  }
  /// The values of prior_variables of the nth draw from the prior, which takes no simulation: a
  /// run's workers simulate it (RunView::for_each_prior_draw).
  virtual std::vector<double> prior_draw(std::uint64_t nth) const = 0;
  /// log p_w of so many blind throws, as a person would make them: what the log p_w of something
  /// found is to be compared with. Always the same ones.
  virtual std::vector<double> log_priors_of_throws(std::size_t /*count*/) const { return {}; }
};

}  // namespace sleight::archive
