// Searches for impacts that gain energy.
//
// A vector of numbers defines an impact. A random search picks the best of many vectors. Hill
// climbing then changes a few of its numbers at a time and keeps improvements. The search must also
// find the gains of laws that are known to gain energy; otherwise, it would prove nothing.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <functional>

#include "common/math/rotation.h"
#include "tests/unit/worker/physics/response/reference.h"

namespace sleight::physics::energy_hunt_test {

using namespace response_reference;

/// Numbers in [0, 1] that define a case.
constexpr std::size_t k_genes = 43;
using Genes = std::array<double, k_genes>;

struct Territory {
  double arm_max = 5;        ///< in radii of gyration
  double floor_mps_max = 0;  ///< of the separation speed
  bool elastic = false;      ///< e = 1 and mu 0 or 1e-9, so that little energy is lost
  bool in_line = false;      ///< centres nearly in line with the normal
};

/// Reads genes in order and scales them.
class Reader {
 public:
  explicit Reader(const Genes& genes) : genes_(genes) {}
  double uniform(double low, double high) { return low + (high - low) * genes_.at(next_++); }
  double spread(double low, double high) { return low * std::pow(high / low, uniform(0, 1)); }
  Vec3 vector() { return {uniform(-1, 1), uniform(-1, 1), uniform(-1, 1)}; }

 private:
  const Genes& genes_;
  std::size_t next_ = 0;
};

Vec3 unit_or_z(const Vec3& v) {
  return math::norm(v) > 1e-3 ? math::normalized(v) : Vec3::UnitZ();
}

Case case_of(const Genes& genes, const Territory& territory) {
  Reader reader(genes);
  Case made;
  made.normal = unit_or_z(reader.vector());
  made.law.restitution = std::min(1.0, reader.uniform(0, 1.5));
  made.law.friction = reader.spread(1e-2, 10);
  made.law.separation_speed_floor_mps = territory.floor_mps_max * reader.uniform(0, 1);
  if (territory.elastic) {
    made.law.restitution = 1;
    made.law.friction = made.law.friction < 0.1 ? 0 : 1e-9;
  }
  const bool alone = reader.uniform(0, 1) < 0.5;
  for (Body* body : {&made.b, &made.a}) {
    Vec3 squares;
    for (Eigen::Index i = 0; i < 3; ++i)
      squares[i] = reader.spread(1e-4, 1);
    body->inertia.mass_kg = reader.spread(1e-2, 1e2);
    body->inertia.principal_kgm2 =
        body->inertia.mass_kg *
        Vec3(squares[1] + squares[2], squares[0] + squares[2], squares[0] + squares[1]);
    body->pose.orientation = math::quaternion_of_rotation_vector(4 * reader.vector());
    Vec3 towards = unit_or_z(reader.vector());
    if (territory.in_line) towards = unit_or_z(made.normal + 1e-6 * towards);
    body->pose.position_m = reader.spread(1e-2, territory.arm_max) * towards;
    body->twist = {reader.vector(), reader.spread(1e-2, 10) * reader.vector()};
    if (alone) break;
  }
  if (dot(contact_velocity(made, made.a.twist, made.b.twist), real(made.normal)) > 0) {
    for (Body* body : {&made.a, &made.b})
      body->twist = {-body->twist.velocity_mps, -body->twist.angular_velocity_radps};
  }
  return made;
}

using Law = std::function<ImpactOutput(const Case&)>;

ImpactOutput guarded(const Case& made) {
  return rigid_impact(input_of(made));
}

Real hunted_gain(const Law& law, const Territory& territory, int tries, int climbs,
                 std::uint64_t seed) {
  Dice dice(seed);
  const auto gain_of = [&](const Genes& genes) {
    const Case made = case_of(genes, territory);
    return relative_gain(made, law(made));
  };
  Real best_of_all = -1;
  constexpr int k_starts = 8;
  for (int start = 0; start < k_starts; ++start) {
    Genes best{};
    Real best_gain = -1;
    for (int i = 0; i < tries / k_starts; ++i) {
      Genes genes;
      for (double& gene : genes)
        gene = dice.uniform(0, 1);
      const Real gain = gain_of(genes);
      if (gain <= best_gain) continue;
      best_gain = gain;
      best = genes;
    }
    for (int i = 0; i < climbs / k_starts; ++i) {
      Genes genes = best;
      do {
        double& gene = genes.at(static_cast<std::size_t>(dice.uniform(0, k_genes)));
        const double step = dice.spread(1e-6, 1) * (dice.once_in(2) ? 1 : -1);
        gene = std::clamp(gene + step, 0.0, 1.0);
      } while (dice.once_in(2));
      const Real gain = gain_of(genes);
      if (gain <= best_gain) continue;
      best_gain = gain;
      best = genes;
    }
    best_of_all = std::max(best_of_all, best_gain);
  }
  ::testing::Test::RecordProperty(fmt::format("gain_{}", seed),
                                  fmt::format("{:.3e}", static_cast<double>(best_of_all)));
  return best_of_all;
}

TEST(EnergyHunt, FindsGainInPlainNewton) {
  // Goal: a short search finds that the commonly used law gains energy (Kane, "A dynamics puzzle",
  // Stanford Mechanics Alumni Club Newsletter, 1984).
  EXPECT_GT(hunted_gain(plain_newton_impact, {}, 4000, 4000, 21), 0.1L);
}

TEST(EnergyHunt, FindsNoGainInOurs) {
  // Goal: the law of rigid_impact.h gains no energy. Method: run long searches among three kinds of
  // impacts: common impacts, impacts whose separation speed has a floor, and almost elastic
  // impacts. With SLEIGHT_SOAK, the searches try 12,000,000 impacts.
  const int times = std::getenv("SLEIGHT_SOAK") != nullptr ? 15 : 1;
  EXPECT_LE(hunted_gain(guarded, {}, times * 150'000, times * 150'000, 21), 1e-13L);
  EXPECT_LE(hunted_gain(guarded, {.floor_mps_max = 10}, times * 150'000, times * 150'000, 22),
            1e-13L);
  EXPECT_LE(hunted_gain(guarded, {.elastic = true}, times * 100'000, times * 100'000, 23), 1e-13L);
}

TEST(EnergyHunt, FindsTheLossOfATerm) {
  // Goal: each term of the law is necessary. Method: run the search on the slow law without faults,
  // and on the slow law with one fault at a time. Only faulty laws may gain energy. In one fault, Q
  // isn't coupled to the normal. In two faults, one of the two bounds of the raised speed is
  // missing. In one fault, friction acts against a slip that has turned.
  const auto faulty = [](Fault fault) {
    return [fault](const Case& made) { return slow_impact(made, fault); };
  };
  const Territory floors{.floor_mps_max = 10};
  EXPECT_GT(hunted_gain(faulty(Fault::uncoupled), {}, 4000, 4000, 24), 0.01L);
  EXPECT_GT(hunted_gain(faulty(Fault::unpaid), floors, 400, 400, 25), 0.1L);
  EXPECT_GT(hunted_gain(faulty(Fault::slip_unpaid), floors, 400, 400, 25), 0.1L);
  EXPECT_GT(hunted_gain(faulty(Fault::turned), {}, 4000, 4000, 24), 0.1L);
  EXPECT_LE(hunted_gain(faulty(Fault::none), floors, 400, 400, 26), 1e-13L);
}

TEST(EnergyHunt, FindsTheLossOfTheGuard) {
  // Goal: rounding alone can make an impact gain energy, but the guard prevents this gain. Method:
  // run one search with the guard and one search without the guard. Contacts are up to 1e6 radii of
  // gyration away from the centres, and the centres are nearly in line with the normal. The impulse
  // is then large, and its rounding error causes a large torque.
  const auto unguarded = [](const Case& made) { return rigid_impact_unguarded(input_of(made)); };
  const Territory far{.arm_max = 1e6, .elastic = true, .in_line = true};
  EXPECT_GT(hunted_gain(unguarded, far, 20'000, 20'000, 27), 1e-12L);
  EXPECT_LE(hunted_gain(guarded, far, 100'000, 100'000, 27), 1e-13L);
}

TEST(EnergyHunt, GuardHardlyTouchesBodiesThatExist) {
  // Goal: the guard changes impulses by less than 1e-12 and abandons no impact. Method: compute
  // random impacts with the guard and without the guard, and compare the impulses. Contacts are up
  // to ten radii of gyration away from the centres.
  Dice dice(28);
  int touched = 0;
  for (int i = 0; i < 100'000; ++i) {
    const Case made = random_case(dice, {.floor_mps_max = 0.5});
    const ImpactOutput with = rigid_impact(input_of(made));
    const ImpactOutput without = rigid_impact_unguarded(input_of(made));
    ASSERT_NE(with.regime, ImpactRegime::separating) << i;
    ASSERT_NE(with.regime, ImpactRegime::unresolved) << i;
    if (with.impulse_ns == without.impulse_ns) continue;
    ++touched;
    ASSERT_GE(with.normal_impulse_ns, (1 - 1e-12) * without.normal_impulse_ns) << i;
  }
  RecordProperty("touched_of_100000", touched);
  EXPECT_LT(touched, 500);
}

}  // namespace sleight::physics::energy_hunt_test
