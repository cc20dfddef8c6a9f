// How much two animations look alike, by their recordings alone.
//
//   value = (mean + greatest) / 2 * (1 + order)                          in metres
//
// mean and greatest: of the distances between a body's centres in the two animations, at 64 equal
// times from the beginning to when 19 in 20 animations of the set are at rest, and at rest itself;
// the mean over bodies and times, the greatest over both. A body that has not entered is where it
// will enter. order: the share of first contacts (of each two things that meet, their first hit, at
// most 256) that does not come in the same order: 1 - longest common subsequence / the longer list.
// So equal paths have 0 however they are told, and another order of hits can double a distance, no
// more.
//
// Bodies that may take each other's place (scene::Feature::twin_of) are matched so that the sum of
// squared distances at nine of the times is least (matching.h): every body is compared with every
// other for that, and squares need no roots.
//
// This is not the likeness distance that decides what a run keeps (docs/SAMPLING.md): that one
// asks the world, this one a recording of any world. It is symmetric, and 0 of an animation and
// itself; the triangle inequality need not hold.
//
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

/// Equal times at which bodies are compared; one more at rest.
inline constexpr std::size_t k_equal_times = 64;
/// Of these and the rest, those at which bodies are matched.
inline constexpr std::size_t k_matching_times = 9;

struct Resemblance {
  double mean_m = 0;
  double greatest_m = 0;
  double order = 0;  ///< 0: all first contacts in the same order; 1: none
  double value_m() const { return 0.5 * (mean_m + greatest_m) * (1 + order); }
};

/// A set of animations of one scene, made ready for comparing.
class Sketches {
 public:
  /// By so many threads, with the same bits by any. REQUIRES: entries of this scene.
  Sketches(std::span<const Entry* const> entries, const scene::Scene& scene,
           std::size_t threads = 1);

  std::size_t size() const { return sketches_.size(); }
  /// Of the entries a and b. The same for (b, a).
  Resemblance between(std::size_t a, std::size_t b) const;

  /// The values of all pairs of some entries, row by row; by so many threads, with the same bits by
  /// any.
  std::vector<float> matrix(std::span<const std::size_t> of, std::size_t threads) const;
  /// Of all.
  std::vector<float> matrix(std::size_t threads) const;

  /// One of them, compared with many others: what that needs of it is worked out once.
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
    /// Of each class of more than one body in turn: x, y, z of its bodies at the matching times,
    /// [time][axis][body].
    std::vector<float> matched_by{};
    std::vector<FirstContact> first{};  ///< in the order of time
  };

  /// Of two places of a body, over the times.
  struct Apart {
    double sum_m = 0;
    double greatest_m = 0;
  };

  Sketch sketch_of(const Entry& entry, double duration_s) const;
  static Apart apart_of(const Places& p, const Places& q);

  std::vector<std::vector<std::uint32_t>> twins_{};  ///< classes of bodies
  double apart_m_ = 0;  ///< how far a body that enters is from one that never does
  std::vector<Sketch> sketches_{};
};

class Sketches::From {
 public:
  /// REQUIRES: `sketches` outlives this.
  From(const Sketches& sketches, std::size_t one);
  /// Of the one and another, as between() says it.
  Resemblance to(std::size_t other);

 private:
  /// Sets partner_of_.
  void match(const Sketch& a, const Sketch& b);
  /// Sets costs_.
  void weigh(const Sketch& a, const Sketch& b, std::span<const std::uint32_t> bodies,
             std::size_t offset);
  /// REQUIRES: partner_of_ of a's bodies.
  double order_between(const Sketch& a, const Sketch& b);

  const Sketches* sketches_;
  std::size_t one_;
  ContactPlaces places_{};  ///< of the one's first contacts
  CheapestMatching matching_{};
  std::vector<double> costs_{};
  std::vector<std::uint32_t> partner_of_{};  ///< by body of the one with the smaller index
  std::vector<std::uint32_t> in_one_{};      ///< by body of the other
};

}  // namespace sleight::browse
