#include "clients/browse/groups.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <map>
#include <mutex>
#include <numeric>
#include <utility>

#include "clients/browse/parallel.h"
#include "common/base/check.h"
#include "common/hash/sha256.h"

namespace sleight::browse {
namespace {

constexpr float k_far = std::numeric_limits<float>::infinity();
/// Maximum representatives whose distances are cached: 40 kB each for 5,000 animations.
constexpr std::size_t k_kept_max = 1024;

struct Nearest {
  std::size_t medoid = 0;  ///< index in the list of medoids
  float distance = k_far;
  float second = k_far;
};

std::vector<Nearest> nearest_of(std::span<const float> matrix, std::size_t size,
                                std::span<const std::size_t> medoids) {
  std::vector<Nearest> nearest(size);
  for (std::size_t point = 0; point < size; ++point) {
    for (std::size_t i = 0; i < medoids.size(); ++i) {
      const float distance = matrix[medoids[i] * size + point];
      if (distance < nearest[point].distance) {
        nearest[point].second = nearest[point].distance;
        nearest[point].distance = distance;
        nearest[point].medoid = i;
      } else {
        nearest[point].second = std::min(nearest[point].second, distance);
      }
    }
  }
  return nearest;
}

/// Adds medoids one by one, always the point that lowers the sum of distances most.
std::vector<std::size_t> first_medoids(std::span<const float> matrix, std::size_t size,
                                       std::size_t k) {
  std::vector<std::size_t> medoids;
  std::vector<bool> is_medoid(size, false);
  std::vector<float> nearest(size, k_far);
  for (std::size_t i = 0; i < k; ++i) {
    std::size_t best = size;
    double best_sum = std::numeric_limits<double>::infinity();
    for (std::size_t candidate = 0; candidate < size; ++candidate) {
      if (is_medoid[candidate]) continue;
      double sum = 0;
      for (std::size_t point = 0; point < size; ++point)
        sum += std::min(nearest[point], matrix[candidate * size + point]);
      if (sum < best_sum) {
        best_sum = sum;
        best = candidate;
      }
    }
    CHECK(best < size);
    medoids.push_back(best);
    is_medoid[best] = true;
    for (std::size_t point = 0; point < size; ++point)
      nearest[point] = std::min(nearest[point], matrix[best * size + point]);
  }
  return medoids;
}

/// Replaces one medoid by another point, such that the sum of distances decreases most. Returns
/// false if no exchange helps.
bool exchange(std::span<const float> matrix, std::size_t size, std::vector<std::size_t>& medoids) {
  const std::vector<Nearest> nearest = nearest_of(matrix, size, medoids);
  // Each medoid's loss: the increase of the sum of distances if only this medoid is removed.
  std::vector<double> loss(medoids.size(), 0);
  for (const Nearest& point : nearest)
    loss[point.medoid] += static_cast<double>(point.second) - static_cast<double>(point.distance);
  double best_change = 0;
  std::pair<std::size_t, std::size_t> best{0, size};
  std::vector<double> change(medoids.size());
  for (std::size_t candidate = 0; candidate < size; ++candidate) {
    if (std::ranges::find(medoids, candidate) != medoids.end()) continue;
    // `common`: the change of the sum that doesn't depend on which medoid the candidate replaces.
    // `change`: the remaining change, for each medoid that the candidate could replace.
    double common = 0;
    std::ranges::copy(loss, change.begin());
    for (std::size_t point = 0; point < size; ++point) {
      const double distance = matrix[candidate * size + point];
      const double first = nearest[point].distance;
      const double second = nearest[point].second;
      if (distance < first) {
        common += distance - first;
        change[nearest[point].medoid] += first - second;
      } else if (distance < second) {
        change[nearest[point].medoid] += distance - second;
      }
    }
    const auto least = std::ranges::min_element(change);
    if (common + *least < best_change) {
      best_change = common + *least;
      best = {static_cast<std::size_t>(least - change.begin()), candidate};
    }
  }
  // Ignore tiny gains, since rounding could cause endless exchanges.
  double total = 0;
  for (const Nearest& point : nearest)
    total += static_cast<double>(point.distance);
  if (best.second == size || -best_change <= 1e-9 * total) return false;
  medoids[best.first] = best.second;
  return true;
}

/// Returns the member with the least sum of distances to the others.
std::size_t central_member(std::span<const float> matrix, std::size_t size,
                           std::span<const std::size_t> members) {
  std::size_t best = members.front();
  double best_sum = std::numeric_limits<double>::infinity();
  for (const std::size_t member : members) {
    double sum = 0;
    for (const std::size_t other : members)
      sum += static_cast<double>(matrix[member * size + other]);
    if (sum < best_sum) {
      best_sum = sum;
      best = member;
    }
  }
  return best;
}

/// The representatives in a sample, and each point's group. With `medoids`, group_of is empty,
/// because each point joins its nearest representative.
struct Division {
  std::vector<std::size_t> representatives;
  std::vector<std::size_t> group_of;
};

Division divided(std::span<const float> matrix, std::size_t size, std::size_t k, Grouping by) {
  if (by == Grouping::medoids)
    return {.representatives = medoids_of(matrix, size, k), .group_of = {}};
  Division division{.representatives = {}, .group_of = hierarchy_of(matrix, size, k)};
  for (std::size_t group = 0; group < k; ++group) {
    std::vector<std::size_t> members;
    for (std::size_t point = 0; point < size; ++point) {
      if (division.group_of[point] == group) members.push_back(point);
    }
    division.representatives.push_back(central_member(matrix, size, members));
  }
  return division;
}

}  // namespace

std::vector<std::size_t> evenly_chosen(std::span<const Entry* const> entries, std::size_t count) {
  std::vector<std::pair<std::string, std::size_t>> hashed;
  for (std::size_t i = 0; i < entries.size(); ++i) {
    const AnimationName& name = entries[i]->name;
    // Hash the old form of names, so that an archive's groups stay the same.
    const std::string text =
        name.is_find ? short_text(name) : fmt::format("{}.{}", name.chain, name.draw);
    hashed.emplace_back(hash::sha256_hex(name.run + "\n" + text), i);
  }
  std::ranges::sort(hashed);
  hashed.resize(std::min(hashed.size(), count));
  std::vector<std::size_t> chosen;
  for (const auto& [hash, i] : hashed)
    chosen.push_back(i);
  std::ranges::sort(chosen, {}, [&](std::size_t i) { return entries[i]->name; });
  return chosen;
}

bool are_comparable(const scene::Scene& a, const scene::Scene& b) {
  if (a.bodies() != b.bodies()) return false;
  for (std::uint32_t body = 0; body < a.bodies(); ++body) {
    if (a.features[body].name != b.features[body].name ||
        a.features[body].twin_of != b.features[body].twin_of)
      return false;
  }
  return true;
}

std::vector<std::size_t> medoids_of(std::span<const float> matrix, std::size_t size,
                                    std::size_t k) {
  CHECK(k >= 1 && k <= size);
  std::vector<std::size_t> medoids = first_medoids(matrix, size, k);
  // exchange() uses each point's second-nearest medoid, so it needs k > 1. For k = 1, the first
  // choice is already the best.
  while (k > 1 && k < size && exchange(matrix, size, medoids)) {
  }
  std::ranges::sort(medoids);
  return medoids;
}

std::vector<std::size_t> hierarchy_of(std::span<const float> matrix, std::size_t size,
                                      std::size_t k) {
  CHECK(k >= 1 && k <= size);
  // Chains of nearest neighbours don't find the merges in order of distance, so sort the merges.
  // The first `size - k` merges then leave k groups.
  struct Merge {
    float distance;
    std::size_t a;
    std::size_t b;
  };
  std::vector<float> between(matrix.begin(), matrix.end());
  std::vector<double> members(size, 1);
  std::vector<bool> is_there(size, true);
  std::vector<Merge> merges;
  std::vector<std::size_t> chain;
  while (merges.size() + 1 < size) {
    if (chain.empty()) {
      chain.push_back(
          static_cast<std::size_t>(std::ranges::find(is_there, true) - is_there.begin()));
    }
    const std::size_t last = chain.back();
    std::size_t nearest = chain.size() > 1 ? chain[chain.size() - 2] : size;
    float distance = nearest == size ? k_far : between[last * size + nearest];
    for (std::size_t other = 0; other < size; ++other) {
      if (other == last || !is_there[other]) continue;
      if (between[last * size + other] < distance || nearest == size) {
        distance = between[last * size + other];
        nearest = other;
      }
    }
    if (chain.size() < 2 || nearest != chain[chain.size() - 2]) {
      chain.push_back(nearest);
      continue;
    }
    // The chain's last two groups are each other's nearest neighbours.
    chain.resize(chain.size() - 2);
    const auto [kept, gone] = std::minmax(last, nearest);
    merges.push_back({.distance = distance, .a = kept, .b = gone});
    for (std::size_t other = 0; other < size; ++other) {
      if (other == kept || other == gone || !is_there[other]) continue;
      const double mean = (members[kept] * static_cast<double>(between[kept * size + other]) +
                           members[gone] * static_cast<double>(between[gone * size + other])) /
                          (members[kept] + members[gone]);
      between[kept * size + other] = static_cast<float>(mean);
      between[other * size + kept] = static_cast<float>(mean);
    }
    members[kept] += members[gone];
    is_there[gone] = false;
  }
  std::ranges::stable_sort(merges, {}, &Merge::distance);
  std::vector<std::size_t> root(size);
  std::iota(root.begin(), root.end(), std::size_t{0});
  const auto root_of = [&](std::size_t point) {
    while (root[point] != point)
      point = root[point] = root[root[point]];
    return point;
  };
  for (std::size_t i = 0; i < size - k; ++i) {
    const auto [low, high] = std::minmax({root_of(merges[i].a), root_of(merges[i].b)});
    root[high] = low;
  }
  std::map<std::size_t, std::size_t> number_of;
  std::vector<std::size_t> group_of;
  for (std::size_t point = 0; point < size; ++point)
    group_of.push_back(number_of.try_emplace(root_of(point), number_of.size()).first->second);
  return group_of;
}

struct AlikeSet::Impl {
  /// The animations of a set that are compared with one another.
  struct Sample {
    Sample(std::vector<std::size_t> chosen, std::size_t all, const Sketches& sketches,
           std::size_t threads)
        : members(std::move(chosen)),
          place_of(all, members.size()),
          matrix(sketches.matrix(members, threads)) {
      for (std::size_t i = 0; i < members.size(); ++i)
        place_of[members[i]] = i;
    }

    std::vector<std::size_t> members;   ///< ascending
    std::vector<std::size_t> place_of;  ///< among the members; their number if not one
    std::vector<float> matrix;
  };

  Impl(std::span<const Entry* const> entries, const scene::Scene& scene, std::size_t given_threads)
      : threads(given_threads),
        by_name(order_of_names(entries)),
        sorted(in_order(entries, by_name)),
        sketches(sorted, scene, threads),
        place_by_name(sorted.size()) {
    for (std::size_t i = 0; i < by_name.size(); ++i)
      place_by_name[by_name[i]] = i;
  }

  static std::vector<std::size_t> order_of_names(std::span<const Entry* const> entries) {
    std::vector<std::size_t> order(entries.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::ranges::sort(order, {}, [&](std::size_t i) { return entries[i]->name; });
    return order;
  }
  static std::vector<const Entry*> in_order(std::span<const Entry* const> entries,
                                            std::span<const std::size_t> order) {
    std::vector<const Entry*> sorted;
    for (const std::size_t i : order)
      sorted.push_back(entries[i]);
    return sorted;
  }
  /// Returns the sample used to form this many groups.
  const Sample& sample_for(std::size_t groups) {
    std::size_t size = sorted.size();
    if (size > k_full_matrix_max)
      size = groups <= k_groups_of_sample_max ? k_sample : k_full_matrix_max;
    const auto known = samples.find(size);
    if (known != samples.end()) return known->second;
    std::vector<std::size_t> chosen(size);
    std::iota(chosen.begin(), chosen.end(), std::size_t{0});
    if (size < sorted.size()) chosen = evenly_chosen(sorted, size);
    return samples.try_emplace(size, std::move(chosen), sorted.size(), sketches, threads)
        .first->second;
  }

  /// Measures the distances from these representatives to all animations, unless they are already
  /// known.
  void measure_from(std::span<const std::size_t> representatives) {
    std::vector<std::size_t> unknown;
    for (const std::size_t one : representatives)
      if (!from.contains(one)) unknown.push_back(one);
    if (from.size() + unknown.size() > k_kept_max) {
      from.clear();
      unknown.assign(representatives.begin(), representatives.end());
    }
    for (const std::size_t one : unknown)
      from[one].resize(sorted.size());
    for_each_block(sorted.size(), threads, [&](std::size_t first, std::size_t end) {
      for (const std::size_t one : unknown) {
        std::vector<double>& distance = from.at(one);
        Sketches::From compared(sketches, one);
        for (std::size_t i = first; i < end; ++i)
          distance[i] = i == one ? -1 : compared.to(i).value_m();
      }
    });
  }

  std::size_t threads;
  std::vector<std::size_t> by_name;
  std::vector<const Entry*> sorted;
  Sketches sketches;
  std::vector<std::size_t> place_by_name;  ///< in `sorted`, by index of the given entries
  std::mutex mutex;                        ///< guards the members below
  std::map<std::size_t, Sample> samples;   ///< by size
  /// Distances from each representative to all animations; -1 for the representative itself.
  std::map<std::size_t, std::vector<double>> from;
};

AlikeSet::AlikeSet(std::span<const Entry* const> entries, const scene::Scene& scene,
                   std::size_t threads)
    : impl_(std::make_unique<Impl>(entries, scene, threads)) {}

AlikeSet::~AlikeSet() = default;

Resemblance AlikeSet::between(std::size_t a, std::size_t b) const {
  return impl_->sketches.between(impl_->place_by_name[a], impl_->place_by_name[b]);
}

Groups AlikeSet::groups(std::size_t groups, Grouping by) const {
  CHECK(groups >= 1);
  Impl& set = *impl_;
  Groups found{.is_approximate = set.sorted.size() > k_full_matrix_max};
  if (set.sorted.empty()) return found;
  const std::lock_guard lock(set.mutex);
  const Impl::Sample& sample = set.sample_for(groups);
  const std::size_t k = std::min(groups, sample.members.size());
  const Division division = divided(sample.matrix, sample.members.size(), k, by);
  for (const std::size_t representative : division.representatives)
    found.groups.push_back({.representative = sample.members[representative]});

  std::vector<std::size_t> representatives;
  for (const AlikeGroup& group : found.groups)
    representatives.push_back(group.representative);
  set.measure_from(representatives);
  std::vector<const std::vector<double>*> from;
  for (const std::size_t one : representatives)
    from.push_back(&set.from.at(one));
  // Animations of the sample keep their group. The others join the nearest representative's group.
  for (std::size_t i = 0; i < set.sorted.size(); ++i) {
    const std::size_t in_sample = sample.place_of[i];
    std::size_t group_of = 0;
    if (in_sample < division.group_of.size()) {
      group_of = division.group_of[in_sample];
    } else {
      for (std::size_t group = 1; group < k; ++group)
        if ((*from[group])[i] < (*from[group_of])[i]) group_of = group;
    }
    AlikeGroup& group = found.groups[group_of];
    group.members.push_back(i);
    const double apart_m = std::max(0.0, (*from[group_of])[i]);
    group.mean_m += apart_m;
    group.greatest_m = std::max(group.greatest_m, apart_m);
  }
  for (AlikeGroup& group : found.groups)
    group.mean_m /= static_cast<double>(group.members.size());
  std::ranges::sort(found.groups, {}, [](const AlikeGroup& group) {
    return std::pair(-static_cast<std::ptrdiff_t>(group.members.size()), group.representative);
  });
  // Map the results back to the order of the given entries.
  for (AlikeGroup& group : found.groups) {
    group.representative = set.by_name[group.representative];
    for (std::size_t& member : group.members)
      member = set.by_name[member];
  }
  return found;
}

Groups groups_of(std::span<const Entry* const> entries, const scene::Scene& scene,
                 const GroupOptions& options) {
  CHECK(options.groups >= 1);
  if (entries.empty()) return {};
  return AlikeSet(entries, scene, options.threads).groups(options.groups, options.by);
}

}  // namespace sleight::browse
