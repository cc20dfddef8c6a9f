// Groups of animations that look alike. Each group has a representative member.
//
// Sets of up to 500 animations are grouped by their full matrix of resemblance (resemblance.h):
//
//   `medoids` chooses k members with a small sum of distances from every animation to its nearest
//     medoid. Medoids are chosen one by one, then exchanged as long as an exchange helps (PAM, by
//     Kaufman and Rousseeuw, "Finding Groups in Data", 1990). All exchanges are evaluated at once
//     (Schubert and Rousseeuw, Information Systems 101, 2021, algorithm 2).
//   `hierarchy` merges the two nearest groups until k are left. The distance between groups is the
//     mean distance of their members (average linkage, by chains of nearest neighbours as in
//     Murtagh, The Computer Journal 26, 1983). If k decreases by 1, two groups become one group.
//
// Larger sets are grouped by a sample of 200 animations, or of 500 if more than 100 groups are
// requested. Other animations join the group with the nearest representative. So sets of more than
// 500 animations allow at most 500 groups. The sample is chosen by a hash of the names, as evenly
// as a random draw. For 5,000 HI animations and 12 medoids, a sample of 200 instead of 500 takes
// half the time, and increases the animations' distances from the medoids by 1.2%.
//
// The result depends only on the set, not on the order in which it is passed: animations are
// processed in the order of their names, and the first of equal choices is taken. Thread safety:
// pure.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "clients/browse/index.h"
#include "clients/browse/resemblance.h"
#include "common/scene/scene.h"

namespace sleight::browse {

/// Largest set whose full matrix is computed.
inline constexpr std::size_t k_full_matrix_max = 500;
/// Sample size for larger sets, up to k_groups_of_sample_max groups.
inline constexpr std::size_t k_sample = 200;
inline constexpr std::size_t k_groups_of_sample_max = 100;

enum class Grouping : std::uint8_t { medoids, hierarchy };

struct GroupOptions {
  std::size_t groups = 12;  ///< maximum number of groups; fewer if there are fewer animations
  Grouping by = Grouping::medoids;
  std::size_t threads = 1;  ///< affects only the time
};

struct AlikeGroup {
  std::size_t representative = 0;      ///< index into the given entries
  std::vector<std::size_t> members{};  ///< includes the representative; ordered by name
  /// Distances of the members from their representative.
  double mean_m = 0;
  double greatest_m = 0;
};

struct Groups {
  std::vector<AlikeGroup> groups{};  ///< largest first; equal sizes by representative
  bool is_approximate = false;       ///< grouped by a sample, as described above
};

/// A set of animations that can be grouped repeatedly. Data for comparisons is computed when first
/// needed, and distances from representatives are cached.
///
/// Thread safety: const functions may be called from several threads at once. Concurrent groups()
/// calls run one after another.
class AlikeSet {
 public:
  /// `threads` affects only the time. REQUIRES: entries of this scene, with different names.
  AlikeSet(std::span<const Entry* const> entries, const scene::Scene& scene, std::size_t threads);
  ~AlikeSet();
  AlikeSet(const AlikeSet&) = delete;
  AlikeSet& operator=(const AlikeSet&) = delete;

  /// REQUIRES: 1 <= groups; groups <= 500 for more than 500 entries.
  Groups groups(std::size_t groups, Grouping by) const;
  Resemblance between(std::size_t a, std::size_t b) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

Groups groups_of(std::span<const Entry* const> entries, const scene::Scene& scene,
                 const GroupOptions& options);

/// Returns `count` of the entries, chosen by a hash of their names: as even as a random draw, and
/// the same for any order of the entries. Sorted by name. REQUIRES: different names.
std::vector<std::size_t> evenly_chosen(std::span<const Entry* const> entries, std::size_t count);

/// Whether two scenes have the same bodies, names and interchangeable bodies, so that their
/// animations can be compared.
bool are_comparable(const scene::Scene& a, const scene::Scene& b);

// Building blocks, exposed for tests. Matrices are complete and stored row by row.

/// Returns the medoids, ascending. REQUIRES: 1 <= k <= size.
std::vector<std::size_t> medoids_of(std::span<const float> matrix, std::size_t size, std::size_t k);
/// Returns each animation's group, 0 to k - 1. REQUIRES: 1 <= k <= size.
std::vector<std::size_t> hierarchy_of(std::span<const float> matrix, std::size_t size,
                                      std::size_t k);

}  // namespace sleight::browse
