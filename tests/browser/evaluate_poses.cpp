// Computes bodies' positions with the C++ code. Tests compare them with the web page's positions
// (pixels.test.mjs, evaluation.test.mjs).
//
// `sleight-evaluate-poses ARCHIVE.h5 < QUESTIONS` answers questions about an archive. Each line of
// QUESTIONS is "NAME TIME_S". Each answer is a line of JSON. If a body hasn't entered, its
// `centre_m` is null:
//
//   {"name", "time_s", "end_s", "bodies": [{"name", "radius_m", "centre_m": [x, y, z]}]}
//
// `sleight-evaluate-poses --segments COUNT SEED FOLDER` writes random segments as columns. The
// segments have all modes. The file segments.bin contains the segments and one time per segment.
// The file expected.bin contains the positions, velocities and orientations at these times. The
// server sends columns to the web page in the same form (clients/gallery_server/packed.h).
#include <fmt/format.h>

#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include "clients/gallery_server/meshes.h"
#include "clients/gallery_server/packed.h"
#include "clients/gallery_server/recording.h"
#include "clients/gallery_server/snapshot.h"
#include "common/archive/hdf5/reader.h"
#include "common/base/error.h"
#include "common/json/value.h"
#include "common/math/rotation.h"
#include "common/motion/fields.h"
#include "common/motion/segment.h"
#include "common/random/stream.h"

namespace {

using namespace sleight;
using Json = json::Value;
using math::Vec3;

Json answer(const gallery::Snapshot& snapshot, const std::string& name, double time_s) {
  const auto entry = snapshot.entry_of(name);
  if (!entry) throw base::Error(base::ExitCode::usage, fmt::format("{}: no such animation", name));
  const motion::Animation animation = snapshot.animation(*entry).motion;
  const scene::Scene& scene = snapshot.index().scene;
  Json bodies = Json::array();
  for (std::uint32_t body = 0; body < animation.bodies(); ++body) {
    const auto centre = animation.path(body).centre_at(time_s);
    bodies.push_back(
        {{"name", scene.features[body].name},
         {"radius_m", gallery::radius_m(scene, body)},
         {"centre_m", centre ? Json{centre->x(), centre->y(), centre->z()} : Json(nullptr)}});
  }
  return {{"name", name}, {"time_s", time_s}, {"end_s", animation.end_s()}, {"bodies", bodies}};
}

int answer_all(const std::string& path) {
  const gallery::Snapshot snapshot(
      path, {.open = [](const std::string& file) { return archive::hdf5::open_file(file); }});
  for (std::string line; std::getline(std::cin, line);) {
    std::istringstream words(line);
    std::string name;
    double time_s = 0;
    if (!(words >> name >> time_s)) {
      fmt::print(stderr, "'{}' is no question\n", line);
      return 2;
    }
    fmt::print("{}\n", answer(snapshot, name, time_s).dump());
  }
  return 0;
}

Vec3 any_vector(random::Stream& stream, double size) {
  return {size * (2 * stream.uniform() - 1), size * (2 * stream.uniform() - 1),
          size * (2 * stream.uniform() - 1)};
}

/// Returns a random vector that is sometimes exactly zero, as in many recordings.
Vec3 vector_or_none(random::Stream& stream, double size) {
  const Vec3 vector = any_vector(stream, size);
  return stream.uniform() < 0.25 ? Vec3(0, 0, 0) : vector;
}

motion::Segment any_segment(random::Stream& stream, std::uint64_t n) {
  return {.body = static_cast<std::uint32_t>(n % 16),
          .start_s = 5 * stream.uniform(),
          .mode = static_cast<motion::Mode>(n % motion::k_mode_names.size()),
          .cause = static_cast<motion::Cause>(n / 4 % motion::k_cause_names.size()),
          .position_m = any_vector(stream, 1),
          .velocity_mps = vector_or_none(stream, 5),
          .acceleration_mps2 = vector_or_none(stream, 20),
          .orientation = math::quaternion_of_rotation_vector(any_vector(stream, 3)),
          .angular_velocity_radps = vector_or_none(stream, 200),
          .angular_acceleration_radps2 = vector_or_none(stream, 1000)};
}

int write_segments(std::uint64_t count, std::uint64_t seed, const std::string& folder) {
  std::vector<motion::Segment> all;
  std::vector<double> time, at, moving, turned;
  for (std::uint64_t n = 0; n < count; ++n) {
    random::Stream stream({.seed = seed, .purpose = random::Purpose::scene}, n);
    const motion::Segment segment = any_segment(stream, n);
    // The time is the segment's start, or within half a second after it.
    const double t_s = segment.start_s + (n % 50 == 0 ? 0 : 0.5 * stream.uniform());
    all.push_back(segment);
    time.push_back(t_s);
    gallery::append(at, motion::position_at(segment, t_s));
    gallery::append(moving, motion::velocity_at(segment, t_s));
    const auto turn = motion::elements_of(motion::orientation_at(segment, t_s));
    turned.insert(turned.end(), turn.begin(), turn.end());
  }
  gallery::Packed segments;
  gallery::add_segments(segments, "", all);
  segments.add("t_s", time);
  gallery::Packed expected;
  expected.add("position_m", at);
  expected.add("velocity_mps", moving);
  expected.add("orientation", turned);
  const Json head{{"segments", count}, {"seed", seed}};
  std::ofstream(folder + "/segments.bin", std::ios::binary) << segments.finish(head);
  std::ofstream(folder + "/expected.bin", std::ios::binary) << expected.finish(head);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    if (argc == 2) return answer_all(argv[1]);
    if (argc == 5 && std::string_view(argv[1]) == "--segments") {
      return write_segments(std::strtoull(argv[2], nullptr, 10),
                            std::strtoull(argv[3], nullptr, 10), argv[4]);
    }
  } catch (const base::Error& error) {
    fmt::print(stderr, "{}\n", error.what());
    return static_cast<int>(error.exit_code());
  }
  fmt::print(stderr,
             "usage: sleight-evaluate-poses ARCHIVE.h5 < QUESTIONS\n"
             "       sleight-evaluate-poses --segments COUNT SEED FOLDER\n");
  return 2;
}
