#include "worker/worlds/ball_2d/ball_2d.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/base/check.h"
#include "common/random/distributions.h"

namespace sleight::worlds::ball_2d {

Ball2d::State Ball2d::draw_prior(random::Stream& stream) const {
  const random::Normal normal{.mean = 0, .sd = parameters_.world.normal_sd_rad};
  State normals{};
  for (std::uint32_t i = 0; i < parameters_.world.collisions; ++i)
    normals[i] = normal.draw(stream);
  return normals;
}

double Ball2d::log_prior(const State& normals) const {
  const random::Normal normal{.mean = 0, .sd = parameters_.world.normal_sd_rad};
  double sum = 0;
  for (std::uint32_t i = 0; i < parameters_.world.collisions; ++i) {
    sum += normal.log_density(normals[i]);
  }
  return sum;
}

Landing Ball2d::simulate(const State& normals) const {
  return simulate_landing(parameters_.world, normals);
}

double Ball2d::log_constraint(const Landing& landing) const {
  const double x_diameters = landing.x_m / parameters_.world.diameter_m;
  const double deviation = (x_diameters - parameters_.constraint.target_diameters) /
                           parameters_.constraint.sigma_diameters;
  return -0.5 * deviation * deviation;
}

bool Ball2d::satisfied(const Landing& landing) const {
  const double x_diameters = landing.x_m / parameters_.world.diameter_m;
  return std::abs(x_diameters - parameters_.constraint.target_diameters) <=
         parameters_.constraint.tolerance_diameters;
}

sampling::Proposal<Ball2d::State> Ball2d::propose(const State& normals,
                                                  std::span<const double> scales,
                                                  random::Stream& stream) const {
  const double scale = scales.empty() ? 1 : scales.front();
  const double half_width = parameters_.proposal.change_half_width_rad * scale;
  const random::Uniform offset{.low = -half_width, .high = half_width};
  State candidate = normals;
  for (std::uint32_t j = 0; j < parameters_.world.collisions; ++j) {
    if (stream.uniform() < parameters_.proposal.change_probability) {
      candidate[j] += offset.draw(stream);
    }
  }
  // q is the same in both directions: the same normals chosen, offsets of equal density.
  return {.candidate = candidate, .log_q_ratio = 0, .kind = 0};
}

base::Bytes Ball2d::encode(const State& normals) const {
  const base::BytesView bytes =
      base::bytes_of(std::span<const double>(normals.data(), parameters_.world.collisions));
  return {bytes.begin(), bytes.end()};
}

std::optional<Ball2d::State> Ball2d::decode(base::BytesView bytes) const {
  base::ByteReader reader(bytes);
  State normals{};
  for (std::uint32_t i = 0; i < parameters_.world.collisions; ++i) {
    const std::optional<double> angle = reader.get<double>();
    if (!angle || !std::isfinite(*angle)) return std::nullopt;
    normals[i] = *angle;
  }
  if (!reader.at_end()) return std::nullopt;
  return normals;
}

std::vector<double> Ball2d::outcome_values(const Landing& landing) const {
  return {landing.x_m, landing.time_s};
}

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

  archive::Recording record(base::BytesView state) const override {
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
    return recording;
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
