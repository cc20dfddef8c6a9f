// Measures how different two animations look, from their recorded motions alone.
//
//   Value in metres = (mean + greatest) / 2 * (1 + order).
//
// `mean` and `greatest` are the mean and the maximum of the distances between a body's centres in
// the two animations, over all bodies, at 64 equally spaced times and at rest. The equally spaced
// times reach from the beginning to the time when 19 of 20 animations of the set are at rest. Until
// a body enters, its centre is taken to be where it will enter. `order` compares the first contacts
// of the two animations: the first hit of each pair of features, at most 256. `order` is 1 -
// longest common subsequence / length of the longer list. So equal paths have the value 0 whatever
// their contacts are, and a different order of contacts can at most double the value.
//
// Interchangeable bodies (scene::Feature::twin_of) are matched so that the sum of squared distances
// at nine of the times is least (matching.h). Squares avoid roots, since every body is compared
// with every other.
//
// Resemblance isn't the likeness distance that decides which animations a run stores
// (docs/SAMPLING.md). The likeness distance is specific to the world, while resemblance works for
// recordings of any world. Resemblance is symmetric, and 0 between an animation and itself, but the
// triangle inequality need not hold.
// Thread safety: const functions may be called from several threads at once.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "clients/browse/contact_places.h"
#include "clients/browse/index.h"
#include "clients/browse/matching.h"
#include "common/scene/scene.h"

namespace sleight::browse {

/// Equally spaced times at which bodies are compared, in addition to the time at rest.
inline constexpr std::size_t k_equal_times = 64;
/// Number of compared times at which bodies are matched, including the time at rest.
inline constexpr std::size_t k_matching_times = 9;

struct Resemblance {
  double mean_m = 0;
  double greatest_m = 0;
  double order = 0;  ///< 0: all first contacts in the same order; 1: none
  double value_m() const { return 0.5 * (mean_m + greatest_m) * (1 + order); }
};

/// A set of animations of one scene, prepared for comparisons.
class Sketches {
 public:
  /// Uses this many threads. The results' bits don't depend on the number of threads. REQUIRES:
  /// entries of this scene.
  Sketches(std::span<const Entry* const> entries, const scene::Scene& scene,
           std::size_t threads = 1);

  std::size_t size() const { return sketches_.size(); }
  /// Compares the entries `a` and `b`, whose order doesn't matter.
  Resemblance between(std::size_t a, std::size_t b) const;

  /// Returns the values of all pairs of the given entries, row by row. The bits don't depend on the
  /// number of threads.
  std::vector<float> matrix(std::span<const std::size_t> of, std::size_t threads) const;
  std::vector<float> matrix(std::size_t threads) const;

  /// Compares one animation with many others, and reuses the data computed for the first.
  class From;

 private:
  static constexpr std::size_t k_times = k_equal_times + 1;
  struct Places {
    float x[k_times];
    float y[k_times];
    float z[k_times];
  };
  struct FirstContact {
    std::uint32_t low = 0;
    std::uint32_t high = 0;
  };
  struct Sketch {
    std::vector<Places> places{};        ///< by body
    std::vector<std::uint8_t> enters{};  ///< by body: 1 or 0
    /// The bodies' coordinates at the matching times. Each class of interchangeable bodies has an
    /// array [time][axis][body]. Classes of one body are omitted.
    std::vector<float> matched_by{};
    std::vector<FirstContact> first{};  ///< in the order of time
  };

  /// How far apart a body's places in two animations are: the sum over the times, and the maximum.
  struct Apart {
    double sum_m = 0;
    double greatest_m = 0;
  };

  Sketch sketch_of(const Entry& entry, double duration_s) const;
  static Apart apart_of(const Places& p, const Places& q);

  std::vector<std::vector<std::uint32_t>> twins_{};  ///< classes of interchangeable bodies
  double apart_m_ = 0;  ///< distance between a body that enters and one that never does
  std::vector<Sketch> sketches_{};
};

class Sketches::From {
 public:
  /// REQUIRES: `sketches` outlives this.
  From(const Sketches& sketches, std::size_t one);
  /// Returns sketches.between(one, other).
  Resemblance to(std::size_t other);

 private:
  void match(const Sketch& a, const Sketch& b);
  void weigh(const Sketch& a, const Sketch& b, std::span<const std::uint32_t> bodies,
             std::size_t offset);
  /// REQUIRES: match() has set partner_of_.
  double order_between(const Sketch& a, const Sketch& b);

  const Sketches* sketches_;
  std::size_t one_;
  ContactPlaces places_{};  ///< first contacts of the one
  CheapestMatching matching_{};
  std::vector<double> costs_{};
  std::vector<std::uint32_t> partner_of_{};  ///< by body of the one with the smaller index
  std::vector<std::uint32_t> in_one_{};      ///< by body of the other
};

}  // namespace sleight::browse
