// Goal: the errors of the elementary functions stay within the bounds that elementary.h states.
// Method: compare with MPFR. Use arguments that are known to be hard, and random arguments from the
// whole domain. The random arguments include denormals, huge angles and numbers near zeros. Their
// seed is fixed.
#include <gtest/gtest.h>

#include <cstdint>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "common/math/angle.h"
#include "common/math/elementary.h"
#include "common/random/stream.h"
#include "tests/support/property.h"
#include "tests/unit/common/math/mpfr_oracle.h"

namespace sleight::math::elementary_accuracy_test {

constexpr std::uint64_t k_seed = 20000;
constexpr std::uint64_t k_arguments_per_range = 20000;
/// MPFR takes a millisecond for each argument in the tail of erfc.
constexpr std::uint64_t k_arguments_for_slow_oracle = 1000;
/// The fast tests (deploy/test) use a fifth of the arguments.
std::uint64_t of_tier(std::uint64_t arguments) {
  return property::of_tier(arguments / 5, arguments);
}
constexpr double k_largest = std::numeric_limits<double>::max();

random::Stream arguments() {
  return random::Stream(
      {.seed = k_seed, .chain = {}, .replica = {}, .purpose = random::Purpose::prior}, 0);
}

/// Draws magnitudes from 2^exponent_min to 2^exponent_max. Every power of two is equally likely.
struct Magnitudes {
  int exponent_min = 0;
  int exponent_max = 0;
  bool both_signs = false;

  double operator()(random::Stream& stream) const {
    const auto span = static_cast<std::uint64_t>(exponent_max - exponent_min);
    const int exponent = exponent_min + static_cast<int>(stream.bits() % span);
    const double magnitude = std::ldexp(1 + stream.uniform(), exponent);
    return both_signs && (stream.bits() & 1) != 0 ? -magnitude : magnitude;
  }
};

struct Interval {
  double low = 0;
  double high = 0;

  double operator()(random::Stream& stream) const { return low + (high - low) * stream.uniform(); }
};

using Generator = std::function<double(random::Stream&)>;
using Ours = std::function<double(double)>;
using Oracle = int (*)(mpfr_t, const mpfr_t, mpfr_rnd_t);

struct Range {
  std::string name;
  Generator generator;
};

struct Case {
  std::string name;
  Ours ours;
  Oracle oracle;
  double k = 1;
  std::vector<Range> ranges;
  std::vector<double> hard;
  std::uint64_t arguments_per_range = k_arguments_per_range;
};

void PrintTo(const Case& c, std::ostream* out) {
  *out << c.name;
}

double error_at(const Case& c, double x) {
  Exact argument(x);
  Exact exact;
  c.oracle(exact.get(), argument.get(), MPFR_RNDN);
  return error_in_bounds(c.ours(x), exact, c.k);
}

std::vector<Range> all_reals() {
  return {{"denormal", Magnitudes{-1074, -1022, true}}, {"tiny", Magnitudes{-1022, -40, true}},
          {"middle", Magnitudes{-40, 40, true}},        {"large", Magnitudes{40, 990, true}},
          {"huge", Magnitudes{990, 1024, true}},        {"ten", Interval{-10, 10}}};
}

// Returns doubles near multiples of pi/2, where the sine or the cosine is almost 0. The first
// double is the closest to such a multiple (Muller, "Elementary functions", 2006, chapter 11).
std::vector<double> near_quarter_turns() {
  std::vector<double> result = {std::ldexp(6381956970095103, 797),
                                std::ldexp(-6381956970095103, 797)};
  for (int power = 0; power < 1000; power += 7) {
    for (const double k : {1.0, 3.0, 5.0, 7.0}) {
      const double x = std::ldexp(k * (k_pi / 2), power);
      result.insert(result.end(), {x, std::nextafter(x, 0), std::nextafter(x, INFINITY)});
    }
  }
  result.insert(result.end(), {k_largest, -k_largest, 0x1p-1074, -0x1p-1074, 0x1p-1022});
  return result;
}

std::vector<double> around(std::vector<double> centres) {
  std::vector<double> result;
  for (const double centre : centres) {
    double below = centre;
    double above = centre;
    for (int step = 0; step < 200; ++step) {
      result.insert(result.end(), {below, above});
      below = std::nextafter(below, -INFINITY);
      above = std::nextafter(above, INFINITY);
    }
  }
  return result;
}

std::vector<Case> cases() {
  const std::vector<Range> unit_interval = {{"inner", Interval{-1, 1}},
                                            {"tiny", Magnitudes{-1022, 0, true}},
                                            {"denormal", Magnitudes{-1074, -1022, true}}};
  const std::vector<Range> log_ranges = {{"all", Magnitudes{-1022, 1024}},
                                         {"denormal", Magnitudes{-1074, -1022}},
                                         {"around 1", Interval{0.5, 2}}};
  return {
      {"sin", sin, mpfr_sin, 1, all_reals(), near_quarter_turns()},
      {"cos", cos, mpfr_cos, 1, all_reals(), near_quarter_turns()},
      {"tan", tan, mpfr_tan, 1, all_reals(), near_quarter_turns()},
      {"sincos_sin", [](double x) { return sincos(x).sin; }, mpfr_sin, 1, all_reals(),
       near_quarter_turns()},
      {"sincos_cos", [](double x) { return sincos(x).cos; }, mpfr_cos, 1, all_reals(),
       near_quarter_turns()},
      {"exp",
       exp,
       mpfr_exp,
       1,
       {{"normal", Interval{-709, 710}},
        {"to denormal", Interval{-746, -707}},
        {"tiny", Magnitudes{-1074, 3, true}}},
       around({-745.13321910194122, -708.39641853226408, 709.78271, 709.783, 0, -1000, 1000})},
      {"expm1",
       expm1,
       mpfr_expm1,
       1,
       {{"normal", Interval{-60, 710}},
        {"negative", Interval{-1000, -30}},
        {"tiny", Magnitudes{-1022, 3, true}},
        {"denormal", Magnitudes{-1074, -1022, true}}},
       around({-37.42994775023705, 709.78271289338397, 0})},
      {"log", log, mpfr_log, 1, log_ranges, around({1, 0x1p-1022, 2, 0.5})},
      {"log1p",
       log1p,
       mpfr_log1p,
       1,
       {{"inner", Interval{-1, 1}},
        {"large", Magnitudes{0, 1024}},
        {"tiny", Magnitudes{-1022, 0, true}},
        {"denormal", Magnitudes{-1074, -1022, true}}},
       around({0x1p60, 0x1p-60, -0x1p-60, -0.5, 1e307})},
      {"asin", asin, mpfr_asin, 1, unit_interval, {1, -1, std::nextafter(1, 0), 0.5, -0.5}},
      {"acos", acos, mpfr_acos, 1, unit_interval, {1, -1, std::nextafter(1, 0), 0.5, -0.5}},
      {"erf",
       erf,
       mpfr_erf,
       1,
       {{"middle", Interval{-7, 7}},
        {"tiny", Magnitudes{-1022, 2, true}},
        {"denormal", Magnitudes{-1074, -1022, true}}},
       {30, -30, 1e300}},
      {"erfc",
       erfc,
       mpfr_erfc,
       1.5,
       {{"middle", Interval{-7, 7}},
        {"tail", Interval{5, 26.6}},
        {"to zero", Interval{26.5, 27.3}}},
       {27.226017111108362, 27.226017111108366, 28, -30, 1e300},
       k_arguments_for_slow_oracle},
  };
}

class ElementaryAccuracy : public testing::TestWithParam<Case> {};

TEST_P(ElementaryAccuracy, errors_stay_within_the_documented_bound) {
  const Case& c = GetParam();
  for (const Range& range : c.ranges) {
    random::Stream stream = arguments();
    double worst = 0;
    double worst_argument = 0;
    for (std::uint64_t i = 0; i < of_tier(c.arguments_per_range); ++i) {
      const double x = range.generator(stream);
      const double error = error_at(c, x);
      if (error > worst) {
        worst = error;
        worst_argument = x;
      }
    }
    EXPECT_LE(worst, 1) << c.name << ", range " << range.name << ", at " << std::hexfloat
                        << worst_argument << ", seed " << std::dec << k_seed;
    RecordProperty(c.name + " " + range.name, std::to_string(worst));
  }
  for (const double x : c.hard)
    EXPECT_LE(error_at(c, x), 1) << c.name << " at " << std::hexfloat << x;
}

INSTANTIATE_TEST_SUITE_P(functions, ElementaryAccuracy, testing::ValuesIn(cases()),
                         [](const auto& instance) { return instance.param.name; });

TEST(ElementaryAccuracyOfTwo, atan2_in_all_quadrants_and_at_all_ratios) {
  random::Stream stream = arguments();
  for (const int spread : {1, 40, 1000}) {
    const Magnitudes magnitudes{-spread, spread, true};
    double worst = 0;
    for (std::uint64_t i = 0; i < of_tier(2 * k_arguments_per_range); ++i) {
      const double y = magnitudes(stream);
      const double x = magnitudes(stream);
      Exact exact_y(y);
      Exact exact_x(x);
      Exact exact;
      mpfr_atan2(exact.get(), exact_y.get(), exact_x.get(), MPFR_RNDN);
      const double error = error_in_bounds(atan2(y, x), exact, 1);
      worst = std::max(worst, error);
      EXPECT_LE(error, 1) << std::hexfloat << y << ", " << x;
    }
    RecordProperty("atan2 spread " + std::to_string(spread), std::to_string(worst));
  }
}

TEST(ElementaryAccuracyOfTwo, pow_for_any_base_and_any_size_of_result) {
  random::Stream stream = arguments();
  double worst = 0;
  const auto judge = [&](double x, double y) {
    Exact exact_x(x);
    Exact exact_y(y);
    Exact exact;
    mpfr_pow(exact.get(), exact_x.get(), exact_y.get(), MPFR_RNDN);
    const double error = error_in_bounds(pow(x, y), exact, 1);
    worst = std::max(worst, error);
    EXPECT_LE(error, 1) << std::hexfloat << x << ", " << y;
  };
  for (std::uint64_t i = 0; i < of_tier(2 * k_arguments_per_range); ++i) {
    // Choose y so that the result's exponent is uniform. Some results are denormals.
    const double x = Magnitudes{-1074, 1024}(stream);
    judge(x, Interval{-1080, 1030}(stream) / std::log2(x));
    // If the base is near 1 and the exponent is huge, an imprecise logarithm has the largest
    // effect.
    const double near_one = 1 + Magnitudes{-50, -2, true}(stream);
    judge(near_one, Interval{-1080, 1030}(stream) / std::log2(near_one));
    const double whole = std::floor(Interval{-40, 40}(stream));
    judge(-Magnitudes{-20, 20}(stream), whole);
  }
  RecordProperty("pow", std::to_string(worst));
}

// Goal: the check of error bounds can fail. Method: a wrong sign, a NaN, a wrong infinity and an
// error of two ulp must exceed the bound. A correctly rounded result must not exceed the bound.
TEST(ErrorInBounds, notices_wrong_results) {
  Exact argument(0.7);
  Exact exact;
  mpfr_sin(exact.get(), argument.get(), MPFR_RNDN);
  const double right = mpfr_get_d(exact.get(), MPFR_RNDN);
  const double off = std::nextafter(std::nextafter(right, 1), 1);
  EXPECT_LE(error_in_bounds(right, exact, 1), 0.5);
  EXPECT_GT(error_in_bounds(off, exact, 1), 1);
  EXPECT_GT(error_in_bounds(-right, exact, 1), 1);
  EXPECT_EQ(error_in_bounds(NAN, exact, 1), INFINITY);
  EXPECT_GT(error_in_bounds(INFINITY, exact, 1), 1);
  Exact denormal(0x1p-1060);
  EXPECT_GT(error_in_bounds(0x1p-1060 + 4 * 0x1p-1074, denormal, 1), 1);
  Exact beyond(1);
  mpfr_mul_2si(beyond.get(), beyond.get(), 2000, MPFR_RNDN);
  EXPECT_EQ(error_in_bounds(INFINITY, beyond, 1), 0);
  EXPECT_GT(error_in_bounds(-INFINITY, beyond, 1), 1);
}

}  // namespace sleight::math::elementary_accuracy_test
