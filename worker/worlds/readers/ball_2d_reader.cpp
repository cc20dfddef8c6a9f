#include "worker/worlds/readers/readers.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "common/base/check.h"
#include "worker/worlds/ball_2d/ball_2d.h"
#include "worker/worlds/ball_2d/motion.h"
#include "worker/worlds/readers/played_out.h"
#include "worker/worlds/scene_parts/scene_parts.h"

namespace sleight::worlds::ball_2d {
namespace {

archive::WorldLayout make_layout(const WorldParameters& world) {
  const archive::Dimension collision{.name = "collision", .size = world.collisions};
  const archive::Dimension axis{.name = "axis_xz", .size = 2};
  return {.world = "ball_2d",
          .variables = {{.name = "normal_rad",
                         .dims = {collision},
                         .unit = "rad",
                         .meaning = "tilt of each collision's normal from the vertical, towards +x",
                         .prior_mean = std::vector<double>(world.collisions, 0),
                         .prior_sd = std::vector<double>(world.collisions, world.normal_sd_rad)}},
          .outcomes = {{.name = "landing_x_m",
                        .unit = "m",
                        .meaning = "x at which the ball lands after its last random collision"},
                       {.name = "landing_time_s",
                        .unit = "s",
                        .meaning = "time from the ball's release to its landing at landing_x_m"}},
          .proposal_kinds = {"change_normals"}};
}

constexpr std::uint32_t k_table = 1;
/// Length of a tilted piece of the table, in ball diameters.
constexpr double k_piece_diameters = 0.9;
constexpr double k_piece_thickness_diameters = 0.04;

/// Places the ball's path in the plane y = 0.
math::Vec3 in_space(const math::Vec2& place) {
  return {place.x(), 0, place.y()};
}

scene::Scene make_scene(const Parameters& parameters) {
  const double diameter_m = parameters.world.diameter_m;
  const double table_z_m =
      -0.5 * diameter_m;  // heights are relative to the centre of a touching ball
  const double drop_m = parameters.world.drop_height_diameters * diameter_m;
  const double target_m = parameters.constraint.target_diameters * diameter_m;
  scene::Scene scene;
  add_feature(scene, scene::FeatureKind::body, "ball");
  add_part(scene, scene::Shape::sphere, {diameter_m, diameter_m, diameter_m});
  CHECK_EQ(add_feature(scene, scene::FeatureKind::fixed, "table"), k_table);
  const double left_m = std::min(0.0, target_m) - 4 * diameter_m;
  const double right_m = std::max(0.0, target_m) + 4 * diameter_m;
  add_part(scene, scene::Shape::ground, {right_m - left_m, 2 * diameter_m, 0},
           {0.5 * (left_m + right_m), 0, table_z_m});
  add_feature(scene, scene::FeatureKind::wanted, "target");
  add_part(scene, scene::Shape::box,
           {2 * parameters.constraint.tolerance_diameters * diameter_m, diameter_m, 0},
           {target_m, 0, table_z_m});
  scene.has_own_parts = true;
  scene.low_m = {left_m, -diameter_m, table_z_m};
  scene.high_m = {right_m, diameter_m, drop_m + diameter_m};
  return scene;
}

class Ball2dReader final : public archive::StateReader {
 public:
  explicit Ball2dReader(const Parameters& parameters)
      : ball_(parameters), layout_(make_layout(parameters.world)), scene_(make_scene(parameters)) {}

  const archive::WorldLayout& layout() const override { return layout_; }

  std::vector<double> variables(base::BytesView state) const override {
    const NormalAngles normals = decoded(ball_, state);
    return {normals.begin(), normals.begin() + collisions()};
  }

  /// The x coordinates of the landing place and of the flights' starts.
  std::vector<double> likeness(base::BytesView state) const override {
    const Motion simulated = motion(state);
    std::vector<double> places_m{simulated.landing.x_m};
    for (const Flight& flight : simulated.flights)
      places_m.push_back(flight.position_m.x());
    return places_m;
  }

  double likeness_distance(std::span<const double> left_m,
                           std::span<const double> right_m) const override {
    double largest_m = 0;
    for (std::size_t i = 0; i < left_m.size(); ++i)
      largest_m = std::max(largest_m, std::abs(left_m[i] - right_m[i]));
    return largest_m / ball_.parameters().world.diameter_m;
  }

  archive::Motion play(base::BytesView state) const override {
    const Motion simulated = motion(state);
    const double gravity_mps2 = ball_.parameters().world.gravity_mps2;
    archive::Motion played;
    motion::Cause cause = motion::Cause::start;
    std::int32_t partner = motion::k_no_partner;
    for (const Flight& flight : simulated.flights) {
      played.segments.push_back({.start_s = flight.start_s,
                                 .mode = motion::Mode::flying,
                                 .cause = cause,
                                 .partner = partner,
                                 .position_m = in_space(flight.position_m),
                                 .velocity_mps = in_space(flight.velocity_mps),
                                 .acceleration_mps2 = {0, 0, -gravity_mps2}});
      cause = motion::Cause::hit;
      partner = k_table;
    }
    played.segments.push_back({.start_s = simulated.landing.time_s,
                               .mode = motion::Mode::resting,
                               .cause = cause,
                               .partner = partner,
                               .position_m = {simulated.landing.x_m, 0, 0}});
    return played;
  }

  const scene::Scene& scene() const override { return scene_; }

  /// The table's pieces. A piece has the tilt of its collision's normal.
  scene::Variation variation(base::BytesView state,
                             std::span<const motion::Segment> segments) const override {
    const NormalAngles normals = decoded(ball_, state);
    const double diameter_m = ball_.parameters().world.diameter_m;
    const double thickness_m = k_piece_thickness_diameters * diameter_m;
    const double side_m = k_piece_diameters * diameter_m;
    scene::Variation own;
    for (std::uint32_t i = 0; i < collisions(); ++i) {
      const math::Quat tilt = math::quaternion_of_rotation_vector({0, normals[i], 0});
      const math::Vec3 down_m = math::rotated(tilt, {0, 0, -0.5 * (diameter_m + thickness_m)});
      own.parts.push_back({.feature = k_table,
                           .shape = scene::Shape::box,
                           .size_m = {side_m, side_m, thickness_m},
                           .position_m = segments[i + 1].position_m + down_m,
                           .orientation = tilt});
    }
    return own;
  }

  std::vector<double> prior_draw(std::uint64_t nth) const override {
    const NormalAngles normals = sampling::nth_prior_draw(ball_, nth);
    return {normals.begin(), normals.begin() + collisions()};
  }

 private:
  std::uint32_t collisions() const { return ball_.parameters().world.collisions; }

  Motion motion(base::BytesView state) const {
    return simulate_motion(ball_.parameters().world, decoded(ball_, state));
  }

  Ball2d ball_;
  archive::WorldLayout layout_;
  scene::Scene scene_;
};

}  // namespace

std::unique_ptr<archive::StateReader> make_state_reader(const Parameters& parameters) {
  return std::make_unique<Ball2dReader>(parameters);
}

}  // namespace sleight::worlds::ball_2d
