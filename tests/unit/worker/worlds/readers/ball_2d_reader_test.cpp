#include "worker/worlds/readers/ball_2d_reader.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "tests/unit/worker/worlds/ball_2d/support.h"
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

  /// After a change of parameters_.
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
  // Goal: every array has the size that its layout says, a name of its own, a unit and a meaning.
  // Method: compare with variables, outcomes and a recording of one state.
  const archive::WorldLayout& layout = reader_->layout();
  const base::Bytes one = state(0);
  EXPECT_EQ(layout.world, "ball_2d");
  EXPECT_EQ(reader_->variables(one).size(), width(layout.variables));
  EXPECT_EQ(width(layout.variables), 7U);
  EXPECT_EQ(Ball2d(parameters_).outcome_values({}).size(), width(layout.outcomes));
  EXPECT_EQ(layout.proposal_kinds.size(), Ball2d(parameters_).proposal_kinds());
  const archive::Recording recording = reader_->play(one).recording;
  EXPECT_EQ(recording.columns, width(layout.segment_columns));
  EXPECT_EQ(recording.rows(), 8U);
  EXPECT_EQ(recording.values.size(), recording.columns * recording.rows());
  std::set<std::string> names;
  for (const auto* variables : {&layout.variables, &layout.outcomes, &layout.segment_columns}) {
    for (const archive::Variable& variable : *variables) {
      EXPECT_TRUE(names.insert(variable.name).second) << variable.name;
      EXPECT_FALSE(variable.unit.empty());
      EXPECT_FALSE(variable.meaning.empty());
    }
  }
}

TEST_F(Reader, VariablesAreTheNormals) {
  // Goal: an archive shows the state's numbers, in order. Method: compare with decode.
  const base::Bytes one = state(3);
  const NormalAngles normals = *Ball2d(parameters_).decode(one);
  const std::vector<double> variables = reader_->variables(one);
  EXPECT_TRUE(std::equal(variables.begin(), variables.end(), normals.begin()));
}

TEST_F(Reader, RecordingsAreOneMotion) {
  // Goal: rows follow one another without a gap, each from the table to the table, and end where
  // the outcome says. Method: evaluate every row's parabola at its end.
  const double g = parameters_.world.gravity_mps2;
  for (std::uint64_t index = 0; index < 200; ++index) {
    const base::Bytes one = state(index);
    const archive::Recording recording = reader_->play(one).recording;
    const NormalAngles normals = *Ball2d(parameters_).decode(one);
    const Landing landing = simulate_landing(parameters_.world, normals);
    double time_s = 0;
    double x_m = 0;
    double z_m = parameters_.world.drop_height_diameters * parameters_.world.diameter_m;
    for (std::size_t row = 0; row < recording.rows(); ++row) {
      const double* at = recording.values.data() + row * recording.columns;
      EXPECT_EQ(at[0], time_s);
      EXPECT_EQ(at[2], x_m);
      EXPECT_NEAR(at[3], z_m, 1e-14);
      time_s = at[0] + at[1];
      x_m = at[2] + at[4] * at[1];
      z_m = at[3] + at[5] * at[1] - g / 2 * at[1] * at[1];
      EXPECT_NEAR(z_m, 0, 1e-14);
      if (row == 0) {
        EXPECT_TRUE(std::isnan(at[6]));
      } else {
        EXPECT_EQ(at[6], normals[row - 1]);
      }
    }
    EXPECT_EQ(time_s, landing.time_s);
    EXPECT_EQ(x_m, landing.x_m);
  }
}

TEST_F(Reader, LikenessIsADistance) {
  // Goal: zero for equal states, the same both ways, the triangle inequality, in ball diameters.
  // Method: random triples; then a ball of another size in the same shape of motion.
  for (std::uint64_t index = 0; index < 300; ++index) {
    const base::Bytes a = state(3 * index);
    const base::Bytes b = state(3 * index + 1);
    const base::Bytes c = state(3 * index + 2);
    const double ab = reader_->likeness_distance(a, b);
    EXPECT_EQ(reader_->likeness_distance(a, a), 0);
    EXPECT_EQ(ab, reader_->likeness_distance(b, a));
    EXPECT_GT(ab, 0);
    EXPECT_LE(ab, reader_->likeness_distance(a, c) + reader_->likeness_distance(c, b) + 1e-12);
  }
  const double before = reader_->likeness_distance(state(0), state(1));
  parameters_.world.diameter_m *= 4;
  remake();
  EXPECT_DOUBLE_EQ(reader_->likeness_distance(state(0), state(1)), before);
}

TEST_F(Reader, LikenessIsTheLargestDifferenceOfPlaces) {
  // Goal: the stated measure. Method: two throws by hand: a flat one stays at x = 0, so the
  // distance is the other's farthest collision.
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
  EXPECT_DOUBLE_EQ(reader_->likeness_distance(ball.encode({}), ball.encode(normals)),
                   farthest_m / parameters_.world.diameter_m);
}

}  // namespace
}  // namespace sleight::worlds::ball_2d
