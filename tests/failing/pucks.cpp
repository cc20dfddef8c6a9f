#include "tests/failing/pucks.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/base/check.h"
#include "common/random/distributions.h"
#include "worker/sampling/target.h"
#include "worker/worlds/scene_parts/scene_parts.h"

namespace sleight::failing {
namespace {

constexpr double k_gravity_mps2 = 9.81;
constexpr double k_side_m = 0.1;
constexpr random::Normal k_speed_mps{.mean = 1.5, .sd = 0.3};
constexpr random::Normal k_gap_m{.mean = 0.5, .sd = 0.1};
constexpr std::array k_normals{k_speed_mps, k_gap_m};

archive::WorldLayout make_layout() {
  return {.world = "pucks",
          .variables = {{.name = "push",
                         .dims = {{.name = "speed_gap", .size = 2}},
                         .unit = "1",
                         .meaning = "the first puck's speed in m/s and the gap in m",
                         .prior_mean = {k_speed_mps.mean, k_gap_m.mean},
                         .prior_sd = {k_speed_mps.sd, k_gap_m.sd}}},
          .outcomes = {{.name = "rest_x_m",
                        .dims = {},
                        .unit = "m",
                        .meaning = "where the second puck rests"}},
          .proposal_kinds = {"move"}};
}

scene::Scene make_scene(const PuckParameters& parameters) {
  using scene::FeatureKind;
  scene::Scene scene;
  for (const char* name : {"puck 1", "puck 2"}) {
    worlds::add_feature(scene, FeatureKind::body, name);
    worlds::add_part(scene, scene::Shape::box, {k_side_m, k_side_m, 0.3 * k_side_m});
  }
  worlds::add_feature(scene, FeatureKind::fixed, "ice");
  worlds::add_part(scene, scene::Shape::ground, {4, 1, 0}, {1.5, 0, -0.15 * k_side_m});
  worlds::add_feature(scene, FeatureKind::wanted, "target");
  worlds::add_part(scene, scene::Shape::box, {2 * parameters.tolerance_m, k_side_m, 0},
                   {parameters.target_m, 0, -0.15 * k_side_m});
  scene.features.back().body = 1;
  scene.low_m = {-0.5, -0.5, -0.15 * k_side_m};
  scene.high_m = {3.5, 0.5, k_side_m};
  return scene;
}

class PucksReader final : public archive::StateReader {
 public:
  explicit PucksReader(const PuckParameters& parameters)
      : pucks_(parameters), layout_(make_layout()), scene_(make_scene(parameters)) {}

  const archive::WorldLayout& layout() const override { return layout_; }
  std::vector<double> variables(base::BytesView state) const override {
    const Pucks::State push = decoded(state);
    return {push.begin(), push.end()};
  }
  std::vector<double> likeness(base::BytesView state) const override {
    const PuckMotion motion = pucks_.simulate(decoded(state));
    return {motion.first_rest_m, motion.second_rest_m};
  }
  double likeness_distance(std::span<const double> a, std::span<const double> b) const override {
    return std::max(std::abs(a[0] - b[0]), std::abs(a[1] - b[1]));
  }

  archive::Motion play(base::BytesView state) const override {
    const Pucks::State push = decoded(state);
    const PuckMotion motion = pucks_.simulate(push);
    const double second_m = k_side_m + std::max(0.0, push[1]);
    archive::Motion played;
    const auto add = [&](motion::Segment segment, double x_m, double speed_mps) {
      segment.position_m = {x_m, 0, 0};
      segment.velocity_mps = {speed_mps, 0, 0};
      segment.mode = speed_mps > 0 ? motion::Mode::sliding : motion::Mode::resting;
      if (speed_mps > 0) segment.acceleration_mps2 = {-motion.deceleration_mps2, 0, 0};
      played.segments.push_back(segment);
    };
    add({.body = 0}, 0, std::max(0.0, push[0]));
    add({.body = 1}, second_m, 0);
    const motion::Cause stop = motion.is_hit ? motion::Cause::hit : motion::Cause::rest;
    add({.body = 0,
         .start_s = motion.first_rest_s,
         .cause = stop,
         .partner = motion.is_hit ? 1 : motion::k_no_partner},
        motion.first_rest_m, 0);
    if (!motion.is_hit) return played;
    add({.body = 1, .start_s = motion.first_rest_s, .cause = stop, .partner = 0}, second_m,
        motion.hit_mps);
    add({.body = 1, .start_s = motion.second_rest_s, .cause = motion::Cause::rest},
        motion.second_rest_m, 0);
    return played;
  }

  const scene::Scene& scene() const override { return scene_; }
  std::vector<double> prior_draw(std::uint64_t nth) const override {
    const Pucks::State push = sampling::nth_prior_draw(pucks_, nth);
    return {push.begin(), push.end()};
  }

 private:
  Pucks::State decoded(base::BytesView state) const {
    const std::optional<Pucks::State> push = pucks_.decode(state);
    CHECK(push.has_value());
    return *push;
  }

  Pucks pucks_;
  archive::WorldLayout layout_;
  scene::Scene scene_;
};

}  // namespace

Pucks::State Pucks::draw_prior(random::Stream& stream) const {
  const double speed_mps = k_speed_mps.draw(stream);
  return {speed_mps, k_gap_m.draw(stream)};
}

double Pucks::log_prior(const State& state) const {
  return k_speed_mps.log_density(state[0]) + k_gap_m.log_density(state[1]);
}

PuckMotion Pucks::simulate(const State& state) const {
  const double speed_mps = std::max(0.0, state[0]);
  const double gap_m = std::max(0.0, state[1]);
  PuckMotion motion{.deceleration_mps2 = parameters_.friction * k_gravity_mps2};
  const double a = motion.deceleration_mps2;
  const double square = speed_mps * speed_mps - 2 * a * gap_m;
  motion.is_hit = square > 0;
  motion.hit_mps = motion.is_hit ? std::sqrt(square) : 0;
  motion.first_rest_s = (speed_mps - motion.hit_mps) / a;
  motion.first_rest_m = motion.is_hit ? gap_m : 0.5 * speed_mps * speed_mps / a;
  motion.second_rest_s = motion.first_rest_s + motion.hit_mps / a;
  motion.second_rest_m = k_side_m + gap_m + 0.5 * motion.hit_mps * motion.hit_mps / a;
  return motion;
}

double Pucks::log_constraint(const PuckMotion& motion) const {
  const double deviation = (motion.second_rest_m - parameters_.target_m) / parameters_.sigma_m;
  return -0.5 * deviation * deviation;
}

bool Pucks::satisfied(const PuckMotion& motion) const {
  return std::abs(motion.second_rest_m - parameters_.target_m) <= parameters_.tolerance_m;
}

sampling::Proposal<Pucks::State> Pucks::propose(const State& state, std::span<const double> scales,
                                                random::Stream& stream) const {
  const double scale = scales.empty() ? 1 : scales.front();
  State candidate = state;
  for (std::size_t i = 0; i < candidate.size(); ++i)
    candidate[i] += random::Normal{.mean = 0, .sd = scale * k_normals[i].sd}.draw(stream);
  return {.candidate = candidate};
}

base::Bytes Pucks::encode(const State& state) const {
  const base::BytesView bytes = base::bytes_of(std::span<const double>(state));
  return {bytes.begin(), bytes.end()};
}

std::optional<Pucks::State> Pucks::decode(base::BytesView bytes) const {
  base::ByteReader reader(bytes);
  State state{};
  for (double& value : state) {
    const std::optional<double> read = reader.get<double>();
    if (!read || !std::isfinite(*read)) return std::nullopt;
    value = *read;
  }
  if (!reader.at_end()) return std::nullopt;
  return state;
}

std::vector<double> Pucks::outcome_values(const PuckMotion& motion) const {
  return {motion.second_rest_m};
}

request::WorldBinding pucks_binding() {
  return request::bind_world<PuckParameters>(
      "pucks", "a puck that is pushed along the ice, and another that must rest at a place",
      [](request::WorldSections& sections, PuckParameters& parameters) {
        sections.world.number(
            "friction", parameters.friction,
            {.minimum = 0.001, .maximum = 10, .help = "between pucks and ice, sliding"});
        const auto length = [&](const char* key, double& value, double minimum, const char* help) {
          sections.constraint.number(
              key, value, {.minimum = minimum, .maximum = 100, .unit = "m", .help = help});
        };
        length("target_m", parameters.target_m, -100, "where the second puck should rest");
        length("sigma_m", parameters.sigma_m, 1e-6, "standard deviation about it");
        length("tolerance_m", parameters.tolerance_m, 1e-6,
               "an animation within it of the target is satisfied");
      });
}

std::unique_ptr<archive::StateReader> make_pucks_reader(const PuckParameters& parameters) {
  return std::make_unique<PucksReader>(parameters);
}

}  // namespace sleight::failing
