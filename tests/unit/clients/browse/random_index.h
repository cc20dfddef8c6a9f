// Random animations of a made-up scene. The scene has two twin balls, another ball, a table and a
// wall.
//
// As in recordings, segments are parabolas, straight lines and rests. Some segments start where the
// previous segment ended; the others start elsewhere. A body may enter late or never. Bodies hit
// fixed features or other bodies; some hits are simultaneous.
#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "clients/browse/index.h"
#include "common/random/stream.h"

namespace sleight::browse::testing {

inline scene::Scene small_scene() {
  using scene::FeatureKind;
  return {.features = {{.name = "ball 1", .twin_of = 0},
                       {.name = "ball 2", .twin_of = 0},
                       {.name = "odd \"one\"", .twin_of = 2},
                       {.name = "table", .kind = FeatureKind::fixed, .twin_of = 3},
                       {.name = "west wall", .kind = FeatureKind::fixed, .twin_of = 4},
                       {.name = "target", .kind = FeatureKind::wanted, .twin_of = 5}},
          .low_m = {-1, -1, 0},
          .high_m = {1, 1, 1}};
}

inline random::Stream stream_of(std::uint64_t seed, std::uint64_t n) {
  return {{.seed = seed, .purpose = random::Purpose::prior}, n};
}

inline double between(random::Stream& stream, double low, double high) {
  return low + (high - low) * stream.uniform();
}

inline std::uint64_t below(random::Stream& stream, std::uint64_t bound) {
  return static_cast<std::uint64_t>(stream.uniform() * static_cast<double>(bound));
}

inline math::Vec3 random_vector(random::Stream& stream, double size) {
  return {between(stream, -size, size), between(stream, -size, size), between(stream, -size, size)};
}

inline Entry random_entry(std::uint64_t draw, random::Stream& stream) {
  constexpr std::uint32_t k_bodies = 3;
  Entry entry{.name = {.run = "run", .draw = draw}, .row = draw, .in_proportion = draw % 2 == 0};
  for (std::uint32_t body = 0; body < k_bodies; ++body) {
    const bool is_absent = body > 0 && stream.uniform() < 0.1;
    const std::uint32_t count = is_absent ? 0 : 1 + static_cast<std::uint32_t>(below(stream, 6));
    entry.tracks.push_back(
        {.first = static_cast<std::uint32_t>(entry.pieces.size()), .count = count});
    double start_s = body == 0 ? 0 : between(stream, 0, 0.3);
    math::Vec3 position_m = random_vector(stream, 1);
    for (std::uint32_t i = 0; i < count; ++i) {
      Piece piece{.start_s = start_s, .position_m = position_m};
      const bool is_last = i + 1 == count;
      if (!is_last) piece.velocity_mps = random_vector(stream, 2);
      if (!is_last && stream.uniform() < 0.7) piece.acceleration_mps2 = {0, 0, -9.81};
      if (!is_last && stream.uniform() < 0.2) piece.acceleration_mps2 = random_vector(stream, 3);
      const double duration_s = stream.uniform() < 0.1 ? 0 : between(stream, 0, 0.4);
      position_m +=
          duration_s * piece.velocity_mps + 0.5 * duration_s * duration_s * piece.acceleration_mps2;
      if (stream.uniform() < 0.1) position_m = random_vector(stream, 1);
      entry.pieces.push_back(piece);
      if (i > 0) {
        auto partner = static_cast<std::uint32_t>(below(stream, 4));
        if (partner >= body) ++partner;
        entry.contacts.push_back({.time_s = start_s, .body = body, .partner = partner});
        ++entry.events;
      }
      if (is_last) entry.end_s = std::max(entry.end_s, start_s);
      start_s += duration_s;
    }
  }
  std::ranges::sort(entry.contacts, {}, [](const Contact& contact) {
    return std::tuple(contact.time_s, contact.body, contact.partner);
  });
  measure_reach(entry);
  entry.numbers.assign(k_own_numbers, 0);
  entry.numbers[k_log_prior] = between(stream, -20, 0);
  entry.numbers[k_draw] = static_cast<double>(draw);
  entry.numbers[k_rest_s] = entry.end_s;
  entry.numbers[k_events] = entry.events;
  entry.numbers.push_back(draw % 5 == 0 ? std::numeric_limits<double>::quiet_NaN()
                                        : between(stream, -1, 1));
  return entry;
}

inline Index random_index(std::size_t animations, random::Stream& stream) {
  Index index{.run_id = "run", .world = "made up", .scene = small_scene()};
  index.numbers = own_numbers();
  index.numbers.push_back({.name = "landing_m", .unit = "m"});
  for (std::uint64_t draw = 0; draw < animations; ++draw)
    index.entries.push_back(random_entry(draw, stream));
  return index;
}

inline std::vector<const Entry*> entries_of(const Index& index) {
  std::vector<const Entry*> entries;
  for (const Entry& entry : index.entries)
    entries.push_back(&entry);
  return entries;
}

}  // namespace sleight::browse::testing
