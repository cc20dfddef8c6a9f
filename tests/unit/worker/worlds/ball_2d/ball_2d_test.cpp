#include "worker/worlds/ball_2d/ball_2d.h"

#include <gtest/gtest.h>

#include <array>
#include <boost/math/distributions/normal.hpp>
#include <cmath>
#include <limits>

#include "common/random/distributions.h"
#include "tests/support/property.h"
#include "tests/unit/common/random/chi_square.h"
#include "tests/unit/worker/worlds/ball_2d/support.h"
#include "worker/worlds/ball_2d/request.h"

namespace sleight::worlds::ball_2d::ball_2d_test {

using testing::k_degree_rad;
using testing::random_normals;
using testing::stream_of;

constexpr std::uint64_t k_seed = 77;

TEST(Ball2d, DefaultsAreTheThesis) {
  // Goal: a request without numbers describes the example of thesis section 2.4.1.
  const std::array worlds{request_binding()};
  const auto request =
      request::read_request("[world]\nname = \"ball_2d\"\n[stop]\nscans = 1\n", "r", worlds);
  ASSERT_TRUE(request.ok());
  const auto& read = request::parameters_of<Parameters>(request.value());
  for (const Parameters& p : {read, Parameters{}}) {
    EXPECT_EQ(p.world.drop_height_diameters, 4.5);
    EXPECT_EQ(p.world.collisions, 5U);
    EXPECT_DOUBLE_EQ(p.world.normal_sd_rad, 10 * k_degree_rad);
    EXPECT_DOUBLE_EQ(p.world.restitution, 1 / std::sqrt(2));
    EXPECT_EQ(p.constraint.target_diameters, 1);
    EXPECT_EQ(p.constraint.sigma_diameters, 0.1);
    EXPECT_EQ(p.constraint.tolerance_diameters, 0.1);
    EXPECT_EQ(p.proposal.change_probability, 0.5);
    EXPECT_DOUBLE_EQ(p.proposal.change_half_width_rad, 5 * k_degree_rad);
  }
  EXPECT_EQ(read.world.normal_sd_rad, Parameters{}.world.normal_sd_rad);
  EXPECT_EQ(read.proposal.change_half_width_rad, Parameters{}.proposal.change_half_width_rad);
}

TEST(Ball2d, LogPriorIsTheSumOfNormalDensities) {
  // Goal: log p_w is the normalised log density of the normals' angles. The world has one normal
  // for each collision. Method: for several numbers of collisions, compare with Boost's density.
  for (const std::uint32_t collisions : {1U, 5U, k_collisions_max}) {
    Parameters parameters;
    parameters.world.collisions = collisions;
    parameters.world.normal_sd_rad = 0.3;
    const Ball2d ball(parameters);
    random::Stream stream = stream_of(k_seed, collisions);
    NormalAngles normals = random_normals(parameters.world, 0.5, stream);
    if (collisions < k_collisions_max) normals.back() = 5;
    double expected = 0;
    for (std::uint32_t i = 0; i < collisions; ++i) {
      expected += std::log(boost::math::pdf(boost::math::normal(0, 0.3), normals[i]));
    }
    EXPECT_NEAR(ball.log_prior(normals), expected, 1e-12 * collisions);
  }
}

TEST(Ball2d, PriorDrawsAreNormal) {
  // Goal: the prior draws the normals' angles independently from N(0, sd), and leaves unused angles
  // at zero. Method: test 20,000 draws by chi-square. Test each angle, and the combination of all
  // signs, because it reveals dependence.
  const Ball2d ball({});
  constexpr int k_cells = 20;
  const boost::math::normal oracle(0, Parameters{}.world.normal_sd_rad);
  std::array<std::vector<int>, 5> counts;
  counts.fill(std::vector<int>(k_cells, 0));
  std::vector<int> signs(32, 0);
  for (const std::uint64_t draw : property::cases(20'000)) {
    random::Stream stream = stream_of(k_seed, draw);
    const NormalAngles normals = ball.draw_prior(stream);
    unsigned sign = 0;
    for (std::size_t i = 0; i < 5; ++i) {
      const double p = boost::math::cdf(oracle, normals[i]);
      ++counts[i][static_cast<std::size_t>(p * k_cells)];
      sign = 2 * sign + (normals[i] > 0 ? 1 : 0);
    }
    ++signs[sign];
    for (std::size_t i = 5; i < normals.size(); ++i)
      ASSERT_EQ(normals[i], 0);
  }
  if (!property::all_cases()) return;
  for (const std::vector<int>& cells : counts)
    random::expect_plausible(random::chi_square_p_value(cells), "normal");
  random::expect_plausible(random::chi_square_p_value(signs), "signs");
}

TEST(Ball2d, ConstraintIsInDiameters) {
  // Goal: if a ball of diameter D lands at x, log p_c is -1/2 ((x/D - target)/sigma)^2. The
  // tolerance includes its edge.
  Parameters parameters;
  parameters.world.diameter_m = 0.5;
  parameters.constraint = {
      .target_diameters = -2, .sigma_diameters = 0.25, .tolerance_diameters = 0.5};
  const Ball2d ball(parameters);
  EXPECT_EQ(ball.log_constraint({.x_m = -1}), 0);
  EXPECT_DOUBLE_EQ(ball.log_constraint({.x_m = -0.5}), -8);
  EXPECT_DOUBLE_EQ(ball.log_constraint({.x_m = -1.125}), -0.5);
  EXPECT_TRUE(ball.satisfied({.x_m = -1.25}));
  EXPECT_TRUE(ball.satisfied({.x_m = -0.75}));
  EXPECT_FALSE(ball.satisfied({.x_m = -0.7499}));
  EXPECT_FALSE(ball.satisfied({.x_m = -1.2501}));
}

TEST(Ball2d, ProposalIsAlgorithm22) {
  // Goal: a proposal changes each normal independently with probability 1/2, by a uniform offset of
  // at most 5 degrees. The proposal's ratio is 1, and its kind is 0. Method: test 20,000 proposals
  // by chi-square: the 32 subsets of changed normals, and the offsets in 20 cells.
  const Ball2d ball({});
  const double half_width = Parameters{}.proposal.change_half_width_rad;
  std::vector<int> subsets(32, 0);
  std::vector<int> offsets(20, 0);
  for (const std::uint64_t draw : property::cases(20'000)) {
    random::Stream stream = stream_of(k_seed, draw);
    const NormalAngles now = random_normals({}, 0.2, stream);
    const auto proposal = ball.propose(now, {}, stream);
    EXPECT_EQ(proposal.log_q_ratio, 0);
    EXPECT_EQ(proposal.kind, 0U);
    unsigned subset = 0;
    for (std::size_t i = 0; i < 5; ++i) {
      const double offset = proposal.candidate[i] - now[i];
      ASSERT_LE(std::abs(offset), half_width * (1 + 1e-12));
      subset = 2 * subset + (offset != 0 ? 1 : 0);
      if (offset == 0) continue;
      const double place = 0.5 * (offset / half_width + 1);
      ++offsets[std::min<std::size_t>(static_cast<std::size_t>(place * 20), 19)];
    }
    ++subsets[subset];
    for (std::size_t i = 5; i < now.size(); ++i)
      ASSERT_EQ(proposal.candidate[i], 0);
  }
  if (!property::all_cases()) return;
  random::expect_plausible(random::chi_square_p_value(subsets), "subsets");
  random::expect_plausible(random::chi_square_p_value(offsets), "offsets");
}

TEST(Ball2d, StatesComeBack) {
  // Goal: decoding an encoded state returns every bit of the state. Method: test random states of
  // several sizes. Each state has a negative zero.
  for (const std::uint32_t collisions : {1U, 5U, k_collisions_max}) {
    Parameters parameters;
    parameters.world.collisions = collisions;
    const Ball2d ball(parameters);
    random::Stream stream = stream_of(k_seed, collisions);
    NormalAngles normals = random_normals(parameters.world, 1, stream);
    normals[0] = -0.0;
    const base::Bytes bytes = ball.encode(normals);
    EXPECT_EQ(bytes.size(), 8U * collisions);
    const std::optional<NormalAngles> back = ball.decode(bytes);
    ASSERT_TRUE(back.has_value());
    EXPECT_EQ(*back, normals);
    EXPECT_EQ(ball.encode(*back), bytes);
  }
}

TEST(Ball2d, RefusesWhatIsNoState) {
  // Goal: decode() refuses bytes if their length is wrong or an angle isn't finite. Method: test
  // every length up to twice the right length. Put NaN and infinities into each place.
  const Ball2d ball({});
  for (std::size_t size = 0; size <= 80; ++size)
    EXPECT_EQ(ball.decode(base::Bytes(size)).has_value(), size == 40) << size;
  const double infinity = std::numeric_limits<double>::infinity();
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(), infinity, -infinity}) {
    for (std::size_t i = 0; i < 5; ++i) {
      NormalAngles normals{};
      normals[i] = bad;
      EXPECT_FALSE(ball.decode(ball.encode(normals)).has_value());
    }
  }
}

}  // namespace sleight::worlds::ball_2d::ball_2d_test
