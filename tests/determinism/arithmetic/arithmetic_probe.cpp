// Evaluates Sleight's arithmetic and libm for many arguments. Prints hashes of the results' bits in
// two lines: "sleight <sha-256>" and "libm <sha-256>". same_bits.sh compares processors and builds.
#include <fmt/format.h>

#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <limits>
#include <span>

#include "common/hash/sha256.h"
#include "common/math/elementary.h"
#include "common/math/rotation.h"
#include "common/math/vector.h"
#include "common/random/distributions.h"

namespace sleight {
namespace {

constexpr std::uint64_t k_seed = 1;
constexpr int k_arguments = 20000;

/// Hashes doubles by their bits.
class BitHash {
 public:
  void add(double x) {
    // The sign of a NaN is not guaranteed.
    const double canonical = std::isnan(x) ? std::numeric_limits<double>::quiet_NaN() : x;
    sha256_.update(std::as_bytes(std::span(&canonical, 1)));
  }
  void add(const math::Vec2& v) {
    add(v.x());
    add(v.y());
  }
  void add(const math::Vec3& v) {
    add(v.x());
    add(v.y());
    add(v.z());
  }
  void add(const math::Quat& q) {
    add(q.w());
    add(math::Vec3(q.x(), q.y(), q.z()));
  }
  std::string finish() { return hash::to_hex(sha256_.finish()); }

 private:
  hash::Sha256 sha256_;
};

random::Stream stream_for(std::uint64_t part) {
  return random::Stream({.seed = k_seed, .purpose = random::Purpose::prior}, part);
}

/// Returns an argument of either sign. Half of the arguments are below 10; the others have any
/// magnitude.
double argument(random::Stream& stream) {
  const double sign = stream.uniform() < 0.5 ? -1 : 1;
  if (stream.uniform() < 0.5) return sign * 10 * stream.uniform();
  const auto exponent = static_cast<int>(random::UniformInteger{2000}.draw(stream)) - 1000;
  return sign * std::ldexp(1 + stream.uniform(), exponent);
}

void add_elementary(BitHash& hash) {
  random::Stream stream = stream_for(0);
  for (int i = 0; i < k_arguments; ++i) {
    const double x = argument(stream);
    const double y = argument(stream);
    const double u = 2 * stream.uniform() - 1;
    const math::SinCos both = math::sincos(x);
    for (const double value :
         {math::sin(x), math::cos(x), math::tan(x), both.sin, both.cos, math::exp(x),
          math::expm1(x), math::log(std::fabs(x)), math::log1p(std::fabs(x)),
          math::pow(std::fabs(x), y), math::atan2(y, x), math::acos(u), math::asin(u), math::erf(x),
          math::erfc(x), std::sqrt(std::fabs(x))}) {
      hash.add(value);
    }
  }
}

void add_vectors(BitHash& hash) {
  random::Stream stream = stream_for(1);
  const random::Normal normal;
  const auto vector = [&] {
    const double x = normal.draw(stream);
    const double y = normal.draw(stream);
    return math::Vec3(x, y, normal.draw(stream));
  };
  math::Quat pose(1, 0, 0, 0);
  math::Vec3 position(0, 0, 0);
  for (int i = 0; i < k_arguments; ++i) {
    const math::Vec3 a = vector();
    const math::Vec3 b = vector();
    const math::Vec2 p(a.x(), b.y());
    // Hash each component, because Eigen may vectorise the expression.
    position += 0.01 * (a - 2 * b) + 0.5 * 0.01 * 0.01 * (b - position / 3);
    hash.add(position);
    hash.add(math::dot(a, b - a));
    hash.add(math::cross(a, b));
    hash.add(math::normalized(a + b));
    hash.add(math::dot(p, math::Vec2(b.x(), b.z())));
    hash.add(math::cross(p, math::Vec2(b.x(), b.z())));
    hash.add(math::normalized(p));
    hash.add(math::rotated(p, b.z()));
    // Multiply a long chain of rotations, in which the effect of one wrong bit would grow.
    pose = math::normalized(math::composed(math::quaternion_of_rotation_vector(0.1 * a), pose));
    hash.add(pose);
    hash.add(math::rotated(math::inverse(pose), b));
    hash.add(math::product(math::matrix_of(pose), a));
  }
}

template <random::Distribution D>
void add_draws(BitHash& hash, std::uint64_t part, const D& distribution) {
  random::Stream stream = stream_for(part);
  for (int i = 0; i < k_arguments; ++i) {
    const auto x = distribution.draw(stream);
    if constexpr (std::is_arithmetic_v<decltype(x)>) {
      hash.add(static_cast<double>(x));
    } else {
      hash.add(x);
    }
    hash.add(distribution.log_density(x));
  }
}

std::string sleight_hash() {
  BitHash hash;
  add_elementary(hash);
  add_vectors(hash);
  add_draws(hash, 2, random::Uniform{.low = -0.1, .high = 0.3});
  add_draws(hash, 3, random::Normal{.mean = 0.1, .sd = 0.7});
  add_draws(hash, 5, random::TruncatedNormal{.mean = 0.1, .sd = 0.7, .low = -1, .high = 2});
  add_draws(hash, 6, random::TruncatedNormal{.mean = 0.1, .sd = 0.7, .low = 0, .high = 0.3});
  add_draws(hash, 7, random::TruncatedNormal{.mean = 0.1, .sd = 0.7, .low = 6});
  add_draws(hash, 8, random::TruncatedNormal{.mean = 0.1, .sd = 0.7, .low = -3.1, .high = -3});
  add_draws(hash, 12, random::UniformDirection2{});
  add_draws(hash, 13, random::UniformDirection3{});
  add_draws(hash, 14, random::UniformRotation{});
  add_draws(hash, 15, random::Bernoulli{.p = 0.3});
  add_draws(hash, 16, random::UniformInteger{.count = 1000003});
  return hash.finish();
}

std::string libm_hash() {
  BitHash hash;
  random::Stream stream = stream_for(0);
  for (int i = 0; i < k_arguments; ++i) {
    const double x = argument(stream);
    const double y = argument(stream);
    for (const double value :
         {std::sin(x), std::exp(x), std::log(std::fabs(x)), std::atan2(y, x)}) {
      hash.add(value);
    }
  }
  return hash.finish();
}

}  // namespace
}  // namespace sleight

int main() {
  fmt::print("sleight {}\nlibm {}\n", sleight::sleight_hash(), sleight::libm_hash());
  return 0;
}
