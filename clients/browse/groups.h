// Animations that look alike, in groups; each has a member that stands for it.
//
// Up to 500 animations the groups are those of the full matrix of resemblance (resemblance.h):
//   medoids    k members so that the sum of everyone's distance to the nearest is small: chosen one
//              by one, then exchanged as long as an exchange helps (PAM: L. Kaufman and
//              P. Rousseeuw, "Finding Groups in Data", 1990; all exchanges weighed at once:
//              E. Schubert and P. Rousseeuw, Information Systems 101, 2021, algorithm 2)
//   hierarchy  the two nearest groups become one until k are left; between groups counts the mean
//              distance of their members (average linkage, by chains of nearest neighbours:
//              F. Murtagh, The Computer Journal 26, 1983). Groups of k are parts of those of k - 1
//
// Of more than 500 the groups are those of 200 of them (of 500 if more than 100 groups are asked
// for), chosen by a hash of their names, as even over the set as a draw; all others go to the group
// whose representative is nearest. So at most 500 groups can be asked for then. 12 medoids of 200
// of 5,000 HI are 1.2% further from everyone than those of 500, and known in half the time.
//
// The result depends on the set alone, not on the order in which it is given: the animations are
// worked through in the order of their names, and of equal choices the first is taken.
//
// Thread safety: pure.
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
/// Of a larger set, so many stand for all, while no more groups than this are asked for.
inline constexpr std::size_t k_sample = 200;
inline constexpr std::size_t k_groups_of_sample_max = 100;

enum class Grouping : std::uint8_t { medoids, hierarchy };

struct GroupOptions {
  std::size_t groups = 12;  ///< so many, or as many as there are animations if that is less
  Grouping by = Grouping::medoids;
  std::size_t threads = 1;  ///< changes nothing but the time
};

struct AlikeGroup {
  std::size_t representative = 0;      ///< of the entries given
  std::vector<std::size_t> members{};  ///< with the representative, by name
  /// Of the members from their representative.
  double mean_m = 0;
  double greatest_m = 0;
};

struct Groups {
  std::vector<AlikeGroup> groups{};  ///< the largest first; of equal ones by their representative
  bool is_approximate = false;       ///< of a part of the animations, as said above
};

/// A set of animations made ready to be put into groups, again and again: what compares them is
/// worked out when it is first needed, and distances to those that stood for a group are kept.
///
/// Thread safety: const functions may be called from several threads at once; one that asks for
/// groups waits for another.
class AlikeSet {
 public:
  /// `threads`: changes nothing but the time. REQUIRES: entries of this scene, with different
  /// names.
  AlikeSet(std::span<const Entry* const> entries, const scene::Scene& scene, std::size_t threads);
  ~AlikeSet();
  AlikeSet(const AlikeSet&) = delete;
  AlikeSet& operator=(const AlikeSet&) = delete;

  /// REQUIRES: 1 <= groups, at most 500 of more than 500 entries.
  Groups groups(std::size_t groups, Grouping by) const;
  /// Of an entry and another, by their places in what was given.
  Resemblance between(std::size_t a, std::size_t b) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// The same of a set that is grouped once.
Groups groups_of(std::span<const Entry* const> entries, const scene::Scene& scene,
                 const GroupOptions& options);

/// So many of the entries, chosen by a hash of their names: as even as a draw, and the same in
/// whatever order they are given. By name. REQUIRES: different names.
std::vector<std::size_t> evenly_chosen(std::span<const Entry* const> entries, std::size_t count);

/// Whether animations of one scene can be compared with those of the other: the same bodies, called
/// the same, of which the same may take each other's place.
bool are_comparable(const scene::Scene& a, const scene::Scene& b);

// What it is made of, on a full matrix row by row.

/// The medoids, ascending. REQUIRES: 1 <= k <= size.
std::vector<std::size_t> medoids_of(std::span<const float> matrix, std::size_t size, std::size_t k);
/// The group, 0 to k - 1, of each. REQUIRES: 1 <= k <= size.
std::vector<std::size_t> hierarchy_of(std::span<const float> matrix, std::size_t size,
                                      std::size_t k);

}  // namespace sleight::browse
