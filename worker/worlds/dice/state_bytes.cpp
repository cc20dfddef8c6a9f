#include <cmath>

#include "common/random/angular_distributions.h"
#include "worker/worlds/dice/state.h"

namespace sleight::worlds::dice {
namespace {

constexpr std::size_t k_override_bytes = 2 * sizeof(std::int32_t) + 3 * sizeof(double);

bool is_finite(const Vec3& v) {
  return std::isfinite(v.x()) && std::isfinite(v.y()) && std::isfinite(v.z());
}

bool is_unit(const Quat& q) {
  const double square = ((q.w() * q.w() + q.x() * q.x()) + q.y() * q.y()) + q.z() * q.z();
  return std::fabs(square - 1) <= random::k_unit_square_tolerance;
}

}  // namespace

base::Bytes encode(const State& state) {
  base::ByteWriter writer;
  const auto put = [&](const Vec3& v) {
    writer.put(v.x());
    writer.put(v.y());
    writer.put(v.z());
  };
  writer.put(state.table_key);
  writer.put(std::uint64_t{state.overrides.size()});
  for (const Override& one : state.overrides) {
    writer.put(one.index.i);
    writer.put(one.index.j);
    writer.put(one.control.height_m);
    writer.put(one.control.restitution);
    writer.put(one.control.friction);
  }
  for (const DieThrow& die : state.dice) {
    put(die.position_m);
    for (const double part :
         {die.orientation.w(), die.orientation.x(), die.orientation.y(), die.orientation.z()})
      writer.put(part);
    put(die.velocity_mps);
    put(die.spin_radps);
  }
  return writer.take();
}

std::optional<State> decode(const WorldParameters& world, base::BytesView bytes) {
  base::ByteReader reader(bytes);
  bool good = true;
  const auto next = [&]<class T>(T absent) {
    const std::optional<T> value = reader.get<T>();
    good = good && value.has_value();
    return value.value_or(absent);
  };
  const auto next_vector = [&] {
    const double x = next(0.0);
    const double y = next(0.0);
    const double z = next(0.0);
    const Vec3 v(x, y, z);
    good = good && is_finite(v);
    return v;
  };
  State state;
  state.table_key = next(std::uint64_t{0});
  const std::uint64_t overrides = next(std::uint64_t{0});
  if (overrides > bytes.size() / k_override_bytes) return std::nullopt;
  for (std::uint64_t nth = 0; good && nth < overrides; ++nth) {
    Override one;
    one.index.i = next(std::int32_t{0});
    one.index.j = next(std::int32_t{0});
    one.control.height_m = next(0.0);
    one.control.restitution = next(0.0);
    one.control.friction = next(0.0);
    good = good && is_on_table(world.table, one.index) &&
           (nth == 0 || state.overrides.back().index < one.index) &&
           is_finite({one.control.height_m, one.control.restitution, one.control.friction}) &&
           std::isfinite(log_density_of(world.table, one.control));
    if (good) state.overrides.push_back(one);
  }
  for (std::size_t die = 0; good && die < world.dice.size(); ++die) {
    DieThrow one;
    one.position_m = next_vector();
    const double w = next(0.0);
    const Vec3 v = next_vector();
    one.orientation = Quat(w, v.x(), v.y(), v.z());
    good = good && is_unit(one.orientation);
    one.velocity_mps = next_vector();
    one.spin_radps = next_vector();
    state.dice.push_back(one);
  }
  if (!good || !reader.at_end()) return std::nullopt;
  return state;
}

}  // namespace sleight::worlds::dice
