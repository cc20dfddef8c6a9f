#include "worker/worlds/readers/ball_2d_reader.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "common/base/check.h"
#include "worker/worlds/ball_2d/ball_2d.h"
#include "worker/worlds/ball_2d/motion.h"

namespace sleight::worlds::ball_2d {
namespace {

archive::WorldLayout make_layout(const WorldParameters& world) {
  const archive::Dimension collision{.name = "collision", .size = world.collisions};
  const archive::Dimension axis{.name = "axis_xz", .size = 2};
  return {
      .world = "ball_2d",
      .variables = {{.name = "normal_rad",
                     .dims = {collision},
                     .unit = "rad",
                     .meaning = "tilt of each collision's normal from the vertical, towards +x"}},
      .outcomes = {{.name = "landing_x_m",
                    .dims = {},
                    .unit = "m",
                    .meaning = "where the ball lands after its last random collision"},
                   {.name = "landing_time_s",
                    .dims = {},
                    .unit = "s",
                    .meaning = "when it lands there, after its release"}},
      .proposal_kinds = {"change_normals"},
      .segment_columns = {
          {.name = "start_s", .dims = {}, .unit = "s", .meaning = "when the hop begins"},
          {.name = "duration_s", .dims = {}, .unit = "s", .meaning = "how long the hop lasts"},
          {.name = "position_m",
           .dims = {axis},
           .unit = "m",
           .meaning =
               "the ball's centre where the hop begins, x right and z up from contact height"},
          {.name = "velocity_mps",
           .dims = {axis},
           .unit = "m s-1",
           .meaning = "the centre's velocity just after the hop's first instant"},
          {.name = "hop_normal_rad",
           .dims = {},
           .unit = "rad",
           .meaning = "the normal's tilt at the collision that began the hop; NaN for the drop"}}};
}

class Ball2dReader final : public archive::StateReader {
 public:
  explicit Ball2dReader(const Parameters& parameters)
      : ball_(parameters), layout_(make_layout(parameters.world)) {}

  const archive::WorldLayout& layout() const override { return layout_; }

  std::vector<double> variables(base::BytesView state) const override {
    const NormalAngles normals = decoded(state);
    return {normals.begin(), normals.begin() + collisions()};
  }

  double likeness_distance(base::BytesView a, base::BytesView b) const override {
    const Motion left = motion(a);
    const Motion right = motion(b);
    double largest_m = std::abs(left.landing.x_m - right.landing.x_m);
    for (std::size_t i = 0; i < left.flights.size(); ++i) {
      largest_m = std::max(
          largest_m, std::abs(left.flights[i].position_m.x() - right.flights[i].position_m.x()));
    }
    return largest_m / ball_.parameters().world.diameter_m;
  }

  archive::Motion play(base::BytesView state) const override {
    const NormalAngles normals = decoded(state);
    const Motion simulated = simulate_motion(ball_.parameters().world, normals);
    archive::Recording recording{.columns = 7, .values = {}};
    for (std::size_t i = 0; i < simulated.flights.size(); ++i) {
      const Flight& flight = simulated.flights[i];
      const double normal_rad = i == 0 ? std::numeric_limits<double>::quiet_NaN() : normals[i - 1];
      recording.values.insert(
          recording.values.end(),
          {flight.start_s, flight.duration_s, flight.position_m.x(), flight.position_m.y(),
           flight.velocity_mps.x(), flight.velocity_mps.y(), normal_rad});
    }
    return {.ends = archive::PlaysOut::yes, .recording = std::move(recording)};
  }

 private:
  std::uint32_t collisions() const { return ball_.parameters().world.collisions; }

  NormalAngles decoded(base::BytesView state) const {
    const std::optional<NormalAngles> normals = ball_.decode(state);
    CHECK(normals.has_value());
    return *normals;
  }

  Motion motion(base::BytesView state) const {
    return simulate_motion(ball_.parameters().world, decoded(state));
  }

  Ball2d ball_;
  archive::WorldLayout layout_;
};

}  // namespace

std::unique_ptr<archive::StateReader> make_state_reader(const Parameters& parameters) {
  return std::make_unique<Ball2dReader>(parameters);
}

}  // namespace sleight::worlds::ball_2d
