#include "worker/worlds/readers/readers.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "tests/unit/worker/worlds/ball_2d/support.h"
#include "tests/unit/worker/worlds/readers/played.h"
#include "worker/worlds/ball_2d/ball_2d.h"

namespace sleight::worlds::ball_2d {
namespace {

using testing::random_normals;
using testing::stream_of;

constexpr std::uint64_t k_seed = 404;

class Reader : public ::testing::Test {
 protected:
  Reader() {
    parameters_.world.collisions = 7;
    parameters_.world.diameter_m = 0.25;
    remake();
  }
  base::Bytes state(std::uint64_t index, double sd_rad = 0.3) const {
    random::Stream stream = stream_of(k_seed, index);
    return Ball2d(parameters_).encode(random_normals(parameters_.world, sd_rad, stream));
  }

  /// Creates the reader again. Call this function whenever parameters_ has changed.
  void remake() { reader_ = make_state_reader(parameters_); }

  Parameters parameters_;
  std::unique_ptr<archive::StateReader> reader_;
};

std::size_t width(const std::vector<archive::Variable>& variables) {
  std::size_t sum = 0;
  for (const archive::Variable& variable : variables)
    sum += variable.size();
  return sum;
}

TEST_F(Reader, LayoutFitsWhatIsGiven) {
  // Goal: every array that the reader returns has the size in the layout. Each variable has a
  // unique name, a unit and a meaning. Method: compare the layout with the variables, outcomes and
  // recording of one state.
  const archive::WorldLayout& layout = reader_->layout();
  const base::Bytes one = state(0);
  EXPECT_EQ(layout.world, "ball_2d");
  EXPECT_EQ(reader_->variables(one).size(), width(layout.variables));
  EXPECT_EQ(width(layout.variables), 7U);
  EXPECT_EQ(Ball2d(parameters_).outcome_values({}).size(), width(layout.outcomes));
  EXPECT_EQ(layout.proposal_kinds.size(), Ball2d(parameters_).proposal_kinds());
  EXPECT_EQ(reader_->play(one).segments.size(), 9U);
  worlds::testing::check_prior_draws(*reader_);
  std::set<std::string> names;
  for (const auto* variables : {&layout.variables, &layout.outcomes}) {
    for (const archive::Variable& variable : *variables) {
      EXPECT_TRUE(names.insert(variable.name).second) << variable.name;
      EXPECT_FALSE(variable.unit.empty());
      EXPECT_FALSE(variable.meaning.empty());
    }
  }
}

TEST_F(Reader, VariablesAreTheNormals) {
  // Goal: the reader returns the angles of a state's normals in order.
  const base::Bytes one = state(3);
  const NormalAngles normals = *Ball2d(parameters_).decode(one);
  const std::vector<double> variables = reader_->variables(one);
  EXPECT_TRUE(std::equal(variables.begin(), variables.end(), normals.begin()));
}

TEST_F(Reader, RecordingsAreOneMotion) {
  // Goal: hops follow each other without a gap, and each hop ends at the table. The last hop ends
  // at the outcome's landing. Under each collision, a piece of the table has the tilt of the
  // collision's normal and touches the ball. Method: evaluate each hop at its end, and compare each
  // piece of the table with the ball's place.
  const double radius_m = parameters_.world.diameter_m / 2;
  for (std::uint64_t index = 0; index < 200; ++index) {
    const base::Bytes one = state(index);
    const motion::Animation animation = worlds::testing::played(*reader_, one);
    const NormalAngles normals = *Ball2d(parameters_).decode(one);
    const Landing landing = simulate_landing(parameters_.world, normals);
    const auto hops = animation.path(0).segments();
    ASSERT_EQ(hops.size(), 9U);
    EXPECT_EQ(hops[0].start_s, 0);
    EXPECT_NEAR(hops[0].position_m.z(),
                parameters_.world.drop_height_diameters * parameters_.world.diameter_m, 1e-14);
    for (std::size_t i = 0; i + 1 < hops.size(); ++i) {
      const math::Vec3 end_m = motion::position_at(hops[i], hops[i + 1].start_s);
      EXPECT_LT(math::norm(math::Vec3(end_m - hops[i + 1].position_m)), 1e-12);
      EXPECT_NEAR(end_m.z(), 0, 1e-12);
      EXPECT_EQ(end_m.y(), 0);
    }
    EXPECT_EQ(hops[8].start_s, landing.time_s);
    EXPECT_EQ(hops[8].position_m.x(), landing.x_m);
    EXPECT_EQ(hops[8].mode, motion::Mode::resting);
    EXPECT_EQ(reader_->scene().features.at(static_cast<std::size_t>(hops[8].partner)).name,
              "table");

    const scene::Variation own = reader_->variation(one, reader_->play(one).segments);
    ASSERT_EQ(own.parts.size(), 7U);
    for (std::size_t i = 0; i < own.parts.size(); ++i) {
      const math::Vec3 up = math::rotated(own.parts[i].orientation, {0, 0, 1});
      EXPECT_NEAR(std::atan2(up.x(), up.z()), normals[i], 1e-12);
      const math::Vec3 top_m = own.parts[i].position_m + 0.5 * own.parts[i].size_m.z() * up;
      const math::Vec3 down_m = hops[i + 1].position_m - top_m;
      EXPECT_NEAR(math::norm(down_m), radius_m, 1e-12);
      EXPECT_NEAR(math::dot(down_m, up), radius_m, 1e-12);
    }
  }
}

TEST_F(Reader, LikenessIsTheLargestDifferenceOfPlaces) {
  // Goal: the distance of two animations is the largest difference between the places of their
  // collisions, in diameters. Method: compare a throw with a flat throw, which stays at x = 0. The
  // distance is then the x of the farthest collision.
  parameters_.world.collisions = 2;
  remake();
  NormalAngles normals{};
  normals[0] = 0.2;
  normals[1] = -0.9;
  const Ball2d ball(parameters_);
  const Motion motion = simulate_motion(parameters_.world, normals);
  const double farthest_m =
      std::max(std::abs(motion.flights[2].position_m.x()), std::abs(motion.landing.x_m));
  EXPECT_GT(farthest_m, 0);
  EXPECT_DOUBLE_EQ(worlds::testing::distance_by(*reader_, ball.encode({}), ball.encode(normals)),
                   farthest_m / parameters_.world.diameter_m);
}

}  // namespace
}  // namespace sleight::worlds::ball_2d
