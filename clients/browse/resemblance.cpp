#include "clients/browse/resemblance.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>
#include <set>
#include <utility>

#include "clients/browse/parallel.h"

namespace sleight::browse {
namespace {

/// Maximum coordinate, to keep squared distances finite floats. No scene is so large.
constexpr double k_place_max_m = 1e18;
/// Share of animations that are at rest at the last of the equally spaced times.
constexpr double k_covered = 0.95;
constexpr std::size_t k_matching_step = k_equal_times / (k_matching_times - 1);
static_assert(k_matching_step * (k_matching_times - 1) == k_equal_times);

/// Returns the time when 19 of 20 animations are at rest.
double covered_duration_s(std::span<const Entry* const> entries) {
  std::vector<double> ends;
  for (const Entry* entry : entries)
    ends.push_back(entry->end_s);
  if (ends.empty()) return 0;
  std::ranges::sort(ends);
  const auto last = static_cast<double>(ends.size() - 1);
  return ends[static_cast<std::size_t>(std::ceil(k_covered * last))];
}

double square(double x) {
  return x * x;
}

float place_of(double x_m) {
  return static_cast<float>(std::clamp(x_m, -k_place_max_m, k_place_max_m));
}

/// Returns the length of the longest increasing subsequence. REQUIRES: at most k_first_contacts_max
/// values.
std::size_t longest_rising(std::span<const std::uint32_t> values) {
  // tails[n]: the least last value of an increasing subsequence of n + 1 values.
  std::array<std::uint32_t, k_first_contacts_max> tails;
  std::size_t length = 0;
  for (const std::uint32_t value : values) {
    // Count smaller tails by bisection without a branch, which would be unpredictable.
    std::size_t less = 0;
    for (std::size_t left = length; left > 0;) {
      const std::size_t half = (left + 1) / 2;
      less += tails[less + half - 1] < value ? half : 0;
      left -= half;
    }
    tails[less] = value;
    length = std::max(length, less + 1);
  }
  return length;
}

}  // namespace

Sketches::Sketches(std::span<const Entry* const> entries, const scene::Scene& scene,
                   std::size_t threads)
    : apart_m_(math::norm(math::Vec3(scene.high_m - scene.low_m))) {
  std::map<std::uint32_t, std::vector<std::uint32_t>> classes;
  for (std::uint32_t body = 0; body < scene.bodies(); ++body)
    classes[scene.features[body].twin_of].push_back(body);
  for (auto& [first, bodies] : classes)
    twins_.push_back(std::move(bodies));
  const double duration_s = covered_duration_s(entries);
  sketches_.resize(entries.size());
  for_each_block(entries.size(), threads, [&](std::size_t first, std::size_t end) {
    for (std::size_t i = first; i < end; ++i)
      sketches_[i] = sketch_of(*entries[i], duration_s);
  });
}

Sketches::Sketch Sketches::sketch_of(const Entry& entry, double duration_s) const {
  Sketch sketch;
  for (std::uint32_t body = 0; body < entry.tracks.size(); ++body) {
    const auto pieces = entry.pieces_of(body);
    sketch.enters.push_back(pieces.empty() ? 0 : 1);
    Places places{};
    for (std::size_t i = 0; i < k_times && !pieces.empty(); ++i) {
      const double t_s = duration_s * static_cast<double>(i) / (k_equal_times - 1);
      const math::Vec3 at_m = i == k_equal_times
                                  ? pieces.back().position_m
                                  : centre_at(pieces, t_s).value_or(pieces.front().position_m);
      places.x[i] = place_of(at_m.x());
      places.y[i] = place_of(at_m.y());
      places.z[i] = place_of(at_m.z());
    }
    sketch.places.push_back(places);
  }
  for (const std::vector<std::uint32_t>& bodies : twins_) {
    if (bodies.size() == 1) continue;
    for (std::size_t i = 0; i < k_times; i += k_matching_step) {
      for (const auto axis : {&Places::x, &Places::y, &Places::z})
        for (const std::uint32_t body : bodies)
          sketch.matched_by.push_back((sketch.places[body].*axis)[i]);
    }
  }
  std::set<std::pair<std::uint32_t, std::uint32_t>> seen;
  for (const Contact& contact : entry.contacts) {
    if (sketch.first.size() == k_first_contacts_max) break;
    const auto [low, high] = std::minmax(contact.body, contact.partner);
    if (seen.emplace(low, high).second) sketch.first.push_back({.low = low, .high = high});
  }
  return sketch;
}

Sketches::From::From(const Sketches& sketches, std::size_t one) : sketches_(&sketches), one_(one) {
  std::uint32_t place = 0;
  for (const FirstContact& contact : sketches.sketches_[one].first)
    places_.add(contact.low, contact.high, place++);
}

void Sketches::From::weigh(const Sketch& a, const Sketch& b, std::span<const std::uint32_t> bodies,
                           std::size_t offset) {
  const std::size_t size = bodies.size();
  costs_.assign(size * size, 0);
  for (std::size_t i = 0; i < size; ++i) {
    double* const row = costs_.data() + i * size;
    for (std::size_t t = 0; t < k_matching_times; ++t) {
      const float* const of_a = a.matched_by.data() + offset + 3 * t * size + i;
      const float* const x = b.matched_by.data() + offset + 3 * t * size;
      const float* const y = x + size;
      const float* const z = y + size;
      const double ax = of_a[0];
      const double ay = of_a[size];
      const double az = of_a[2 * size];
      for (std::size_t j = 0; j < size; ++j)
        row[j] += square(ax - double{x[j]}) + square(ay - double{y[j]}) + square(az - double{z[j]});
    }
    for (std::size_t j = 0; j < size; ++j) {
      if (a.enters[bodies[i]] != b.enters[bodies[j]])
        row[j] = square(sketches_->apart_m_) * k_matching_times;
    }
  }
}

void Sketches::From::match(const Sketch& a, const Sketch& b) {
  partner_of_.resize(a.places.size());
  std::size_t offset = 0;
  for (const std::vector<std::uint32_t>& bodies : sketches_->twins_) {
    if (bodies.size() == 1) {
      partner_of_[bodies.front()] = bodies.front();
      continue;
    }
    weigh(a, b, bodies, offset);
    offset += 3 * k_matching_times * bodies.size();
    const auto column_of = matching_.of(costs_, bodies.size());
    for (std::size_t i = 0; i < bodies.size(); ++i)
      partner_of_[bodies[i]] = bodies[column_of[i]];
  }
}

double Sketches::From::order_between(const Sketch& a, const Sketch& b) {
  const std::size_t longer = std::max(a.first.size(), b.first.size());
  if (longer == 0) return 0;
  // Map the bodies of the other animation to the matched bodies of `one`.
  const Sketch& one = sketches_->sketches_[one_];
  in_one_ = partner_of_;
  if (&one == &a) {
    for (std::uint32_t body = 0; body < partner_of_.size(); ++body)
      in_one_[partner_of_[body]] = body;
  }
  const auto in_one = [&](std::uint32_t feature) {
    return feature < in_one_.size() ? in_one_[feature] : feature;
  };
  // Look up the positions of one list's contacts in the other list. Contacts of a list are
  // distinct, so the longest common subsequence is the longest increasing subsequence of these
  // positions.
  std::array<std::uint32_t, k_first_contacts_max> places;
  std::size_t count = 0;
  for (const FirstContact& contact : (&one == &a ? b : a).first) {
    const auto [low, high] = std::minmax({in_one(contact.low), in_one(contact.high)});
    const std::uint32_t place = places_.find(low, high);
    places[count] = place;
    count += place == ContactPlaces::k_none ? 0 : 1;
  }
  const std::size_t same = longest_rising(std::span(places).first(count));
  return 1 - static_cast<double>(same) / static_cast<double>(longer);
}

Sketches::Apart Sketches::apart_of(const Places& p, const Places& q) {
  // Sum in four lanes, which the processor adds in parallel.
  constexpr std::size_t k_lanes = 4;
  double sum[k_lanes] = {};
  float greatest[k_lanes] = {};
  float apart_m[k_times];
  for (std::size_t i = 0; i < k_times; ++i) {
    const float dx = p.x[i] - q.x[i];
    const float dy = p.y[i] - q.y[i];
    const float dz = p.z[i] - q.z[i];
    apart_m[i] = std::sqrt(dx * dx + dy * dy + dz * dz);
  }
  for (std::size_t i = 0; i + k_lanes <= k_times; i += k_lanes) {
    for (std::size_t lane = 0; lane < k_lanes; ++lane) {
      sum[lane] += double{apart_m[i + lane]};
      greatest[lane] = std::max(greatest[lane], apart_m[i + lane]);
    }
  }
  static_assert(k_times % k_lanes == 1);  // at rest
  const float at_rest_m = apart_m[k_times - 1];
  return {.sum_m = sum[0] + sum[1] + (sum[2] + sum[3]) + double{at_rest_m},
          .greatest_m =
              double{std::max({greatest[0], greatest[1], greatest[2], greatest[3], at_rest_m})}};
}

Resemblance Sketches::From::to(std::size_t other) {
  // Order the two animations, so that the result is symmetric to the last bit.
  const Sketch& a = sketches_->sketches_[std::min(one_, other)];
  const Sketch& b = sketches_->sketches_[std::max(one_, other)];
  match(a, b);
  Resemblance found;
  for (std::uint32_t body = 0; body < a.places.size(); ++body) {
    const std::uint32_t partner = partner_of_[body];
    Apart apart{.sum_m = sketches_->apart_m_ * k_times, .greatest_m = sketches_->apart_m_};
    if (a.enters[body] == b.enters[partner]) apart = apart_of(a.places[body], b.places[partner]);
    found.mean_m += apart.sum_m / k_times;
    found.greatest_m = std::max(found.greatest_m, apart.greatest_m);
  }
  if (!a.places.empty()) found.mean_m /= static_cast<double>(a.places.size());
  found.order = order_between(a, b);
  return found;
}

Resemblance Sketches::between(std::size_t a, std::size_t b) const {
  return From(*this, a).to(b);
}

std::vector<float> Sketches::matrix(std::span<const std::size_t> of, std::size_t threads) const {
  const std::size_t size = of.size();
  std::vector<float> values(size * size, 0);
  // Compare in blocks whose sketches fit into the processor's cache. Each row has one thread, which
  // alone writes the row's elements and their mirror images below the diagonal.
  constexpr std::size_t k_block = 16;
  const auto compare = [&](std::size_t first, std::size_t end) {
    std::vector<From> rows;
    for (std::size_t row = first; row < end; ++row)
      rows.emplace_back(*this, of[row]);
    for (std::size_t left = first; left < size; left += k_block) {
      for (std::size_t row = first; row < end; ++row) {
        const std::size_t right = std::min(left + k_block, size);
        for (std::size_t column = std::max(left, row + 1); column < right; ++column) {
          const auto value = static_cast<float>(rows[row - first].to(of[column]).value_m());
          values[row * size + column] = value;
          values[column * size + row] = value;
        }
      }
    }
  };
  for_each_block((size + k_block - 1) / k_block, threads, [&](std::size_t first, std::size_t end) {
    for (std::size_t block = first; block < end; ++block)
      compare(block * k_block, std::min((block + 1) * k_block, size));
  });
  return values;
}

std::vector<float> Sketches::matrix(std::size_t threads) const {
  std::vector<std::size_t> all(size());
  std::iota(all.begin(), all.end(), std::size_t{0});
  return matrix(all, threads);
}

}  // namespace sleight::browse
