#include "clients/browse/resemblance.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <set>
#include <utility>

#include "clients/browse/parallel.h"
#include "common/base/check.h"

namespace sleight::browse {
namespace {

constexpr double k_infinity = std::numeric_limits<double>::infinity();
/// Beyond it values are equally far, so that sums of them are finite: no scene is so large.
constexpr double k_value_max_m = 1e30;
/// Of all rest times, the part that the equal times reach.
constexpr double k_covered = 0.95;

/// When 19 in 20 of the animations are at rest.
double covered_duration_s(std::span<const Entry* const> entries) {
  std::vector<double> ends;
  for (const Entry* entry : entries)
    ends.push_back(entry->end_s);
  if (ends.empty()) return 0;
  std::ranges::sort(ends);
  const auto last = static_cast<double>(ends.size() - 1);
  return ends[static_cast<std::size_t>(std::ceil(k_covered * last))];
}

double distance_m(const float* ax, const float* ay, const float* az, const float* bx,
                  const float* by, const float* bz, std::size_t i) {
  // A hostile archive's places may be so large that their squares are no floats.
  const double dx = double{ax[i]} - double{bx[i]};
  const double dy = double{ay[i]} - double{by[i]};
  const double dz = double{az[i]} - double{bz[i]};
  return std::sqrt(dx * dx + dy * dy + dz * dz);
}

/// Length of the longest rising subsequence.
std::size_t longest_rising(std::span<const std::uint32_t> values) {
  // tails[n]: the least value at which a rising subsequence of n + 1 values ends.
  std::array<std::uint32_t, k_first_contacts_max> tails{};
  std::size_t length = 0;
  for (const std::uint32_t value : values) {
    const auto at = static_cast<std::size_t>(
        std::lower_bound(tails.begin(), tails.begin() + length, value) - tails.begin());
    tails[at] = value;
    length = std::max(length, at + 1);
  }
  return length;
}

}  // namespace

std::vector<std::uint32_t> cheapest_matching(std::span<const double> costs, std::size_t size) {
  CHECK_EQ(costs.size(), size * size);
  // Rows and columns count from 1, 0 is none: row_of[column] is matched, and the potentials keep
  // every cost[row][column] - u[row] - v[column] at 0 or above, 0 where matched.
  std::vector<double> u(size + 1, 0);
  std::vector<double> v(size + 1, 0);
  std::vector<std::size_t> row_of(size + 1, 0);
  std::vector<std::size_t> came_from(size + 1, 0);
  for (std::size_t row = 1; row <= size; ++row) {
    // Grow a tree of shortest paths from the row until it reaches a column that is free.
    std::vector<double> shortest(size + 1, k_infinity);
    std::vector<bool> is_done(size + 1, false);
    row_of[0] = row;
    std::size_t column = 0;
    do {
      is_done[column] = true;
      const std::size_t from = row_of[column];
      double step = k_infinity;
      std::size_t nearest = 0;
      for (std::size_t other = 1; other <= size; ++other) {
        if (is_done[other]) continue;
        const double reduced = costs[(from - 1) * size + other - 1] - u[from] - v[other];
        if (reduced < shortest[other]) {
          shortest[other] = reduced;
          came_from[other] = column;
        }
        if (shortest[other] < step) {
          step = shortest[other];
          nearest = other;
        }
      }
      for (std::size_t other = 0; other <= size; ++other) {
        if (is_done[other]) {
          u[row_of[other]] += step;
          v[other] -= step;
        } else {
          shortest[other] -= step;
        }
      }
      column = nearest;
    } while (row_of[column] != 0);
    // Turn the path round.
    while (column != 0) {
      row_of[column] = row_of[came_from[column]];
      column = came_from[column];
    }
  }
  std::vector<std::uint32_t> column_of(size);
  for (std::size_t column = 1; column <= size; ++column)
    column_of[row_of[column] - 1] = static_cast<std::uint32_t>(column - 1);
  return column_of;
}

Sketches::Sketches(std::span<const Entry* const> entries, const scene::Scene& scene)
    : apart_m_(math::norm(math::Vec3(scene.high_m - scene.low_m))) {
  std::map<std::uint32_t, std::vector<std::uint32_t>> classes;
  for (std::uint32_t body = 0; body < scene.bodies(); ++body)
    classes[scene.features[body].twin_of].push_back(body);
  for (auto& [first, bodies] : classes)
    twins_.push_back(std::move(bodies));
  const double duration_s = covered_duration_s(entries);
  sketches_.reserve(entries.size());
  for (const Entry* entry : entries)
    sketches_.push_back(sketch_of(*entry, duration_s));
}

Sketches::Sketch Sketches::sketch_of(const Entry& entry, double duration_s) const {
  Sketch sketch;
  for (std::uint32_t body = 0; body < entry.tracks.size(); ++body) {
    const auto pieces = entry.pieces_of(body);
    sketch.enters.push_back(!pieces.empty());
    Places places{};
    for (std::size_t i = 0; i < k_times && !pieces.empty(); ++i) {
      const double t_s = duration_s * static_cast<double>(i) / (k_equal_times - 1);
      const math::Vec3 at_m = i == k_equal_times
                                  ? pieces.back().position_m
                                  : centre_at(pieces, t_s).value_or(pieces.front().position_m);
      places.x[i] = static_cast<float>(at_m.x());
      places.y[i] = static_cast<float>(at_m.y());
      places.z[i] = static_cast<float>(at_m.z());
    }
    sketch.places.push_back(places);
  }
  std::set<std::pair<std::uint32_t, std::uint32_t>> seen;
  for (const Contact& contact : entry.contacts) {
    if (sketch.first.size() == k_first_contacts_max) break;
    const auto [low, high] = std::minmax(contact.body, contact.partner);
    if (!seen.emplace(low, high).second) continue;
    const auto place = static_cast<std::uint32_t>(sketch.first.size());
    sketch.first.push_back({.low = low, .high = high});
    sketch.by_things.push_back({.low = low, .high = high, .place = place});
  }
  std::ranges::sort(sketch.by_things);
  return sketch;
}

std::vector<std::uint32_t> Sketches::matched(const Sketch& a, const Sketch& b) const {
  std::vector<std::uint32_t> partner_of(a.places.size());
  std::vector<double> costs;
  for (const std::vector<std::uint32_t>& bodies : twins_) {
    if (bodies.size() == 1) {
      partner_of[bodies.front()] = bodies.front();
      continue;
    }
    costs.clear();
    for (const std::uint32_t of_a : bodies) {
      for (const std::uint32_t of_b : bodies) {
        double cost = 0;
        if (a.enters[of_a] != b.enters[of_b]) {
          cost = apart_m_ * k_matching_times;
        } else {
          const Places& p = a.places[of_a];
          const Places& q = b.places[of_b];
          for (std::size_t i = 0; i < k_times; i += (k_times - 1) / (k_matching_times - 1))
            cost += distance_m(p.x, p.y, p.z, q.x, q.y, q.z, i);
        }
        costs.push_back(cost);
      }
    }
    const auto column_of = cheapest_matching(costs, bodies.size());
    for (std::size_t i = 0; i < bodies.size(); ++i)
      partner_of[bodies[i]] = bodies[column_of[i]];
  }
  return partner_of;
}

double Sketches::order_between(const Sketch& a, const Sketch& b,
                               const std::vector<std::uint32_t>& partner_of) const {
  const std::size_t longer = std::max(a.first.size(), b.first.size());
  if (longer == 0) return 0;
  // Where each of b's contacts stands. No two of a list are equal, so that the longest common
  // subsequence is the longest one of a's whose places in b rise.
  std::array<std::uint32_t, k_first_contacts_max> places{};
  std::size_t count = 0;
  const auto in_b = [&](std::uint32_t feature) {
    return feature < partner_of.size() ? partner_of[feature] : feature;
  };
  for (const FirstContact& contact : a.first) {
    const auto [low, high] = std::minmax({in_b(contact.low), in_b(contact.high)});
    const PlacedContact sought{.low = low, .high = high};
    const auto found = std::ranges::lower_bound(b.by_things, sought);
    if (found != b.by_things.end() && found->low == low && found->high == high)
      places[count++] = found->place;
  }
  const std::size_t same = longest_rising(std::span(places).first(count));
  return 1 - static_cast<double>(same) / static_cast<double>(longer);
}

Resemblance Sketches::between(std::size_t a, std::size_t b) const {
  if (a > b) std::swap(a, b);
  const Sketch& of_a = sketches_[a];
  const Sketch& of_b = sketches_[b];
  const std::vector<std::uint32_t> partner_of = matched(of_a, of_b);
  Resemblance found;
  for (std::uint32_t body = 0; body < of_a.places.size(); ++body) {
    const std::uint32_t other = partner_of[body];
    double sum = 0;
    double greatest = 0;
    if (of_a.enters[body] != of_b.enters[other]) {
      sum = apart_m_ * k_times;
      greatest = apart_m_;
    } else {
      const Places& p = of_a.places[body];
      const Places& q = of_b.places[other];
      for (std::size_t i = 0; i < k_times; ++i) {
        const double apart = distance_m(p.x, p.y, p.z, q.x, q.y, q.z, i);
        sum += apart;
        greatest = std::max(greatest, apart);
      }
    }
    found.mean_m += sum / k_times;
    found.greatest_m = std::max(found.greatest_m, greatest);
  }
  if (!of_a.places.empty()) found.mean_m /= static_cast<double>(of_a.places.size());
  found.order = order_between(of_a, of_b, partner_of);
  return found;
}

std::vector<float> Sketches::matrix(std::span<const std::size_t> of, std::size_t threads) const {
  const std::size_t size = of.size();
  std::vector<float> values(size * size, 0);
  // A row is one thread's; what stands below the diagonal is of another row, and no other writes
  // it.
  for_each_block(size, threads, [&](std::size_t first, std::size_t end) {
    for (std::size_t row = first; row < end; ++row) {
      for (std::size_t column = row + 1; column < size; ++column) {
        const auto value =
            static_cast<float>(std::min(between(of[row], of[column]).value_m(), k_value_max_m));
        values[row * size + column] = value;
        values[column * size + row] = value;
      }
    }
  });
  return values;
}

std::vector<float> Sketches::matrix(std::size_t threads) const {
  std::vector<std::size_t> all(size());
  std::iota(all.begin(), all.end(), std::size_t{0});
  return matrix(all, threads);
}

}  // namespace sleight::browse
