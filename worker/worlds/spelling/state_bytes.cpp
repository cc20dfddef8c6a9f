#include <cmath>

#include "worker/worlds/spelling/proposals.h"

namespace sleight::worlds::spelling {

std::vector<double> values_of(const State& state) {
  std::vector<double> values;
  for (const Vec3& offset_m : state.offsets_m)
    values.insert(values.end(), {offset_m.x(), offset_m.y(), offset_m.z()});
  for (const std::uint8_t active : state.active)
    values.push_back(active);
  for (const Vec2& drop_m : state.drops_m)
    values.insert(values.end(), {drop_m.x(), drop_m.y()});
  return values;
}

base::Bytes encode(const State& state) {
  const std::vector<double> values = values_of(state);
  const base::BytesView bytes = base::bytes_of(std::span<const double>(values));
  return {bytes.begin(), bytes.end()};
}

std::optional<State> decode(const Prior& prior, base::BytesView bytes) {
  base::ByteReader reader(bytes);
  bool good = true;
  const auto next = [&] {
    const std::optional<double> value = reader.get<double>();
    good = good && value && std::isfinite(*value);
    return good ? *value : 0;
  };
  State state;
  for (std::uint32_t v = 0; v < prior.vertices; ++v) {
    const double x = next();
    const double y = next();
    const double z = next();
    state.offsets_m.emplace_back(x, y, z);
  }
  for (std::uint32_t ball = 0; ball < prior.balls; ++ball) {
    const double active = next();
    good = good && (active == 0 || active == 1);
    state.active.push_back(active == 1 ? 1 : 0);
  }
  for (std::uint32_t ball = 0; ball < prior.balls; ++ball) {
    const double x = next();
    const double y = next();
    state.drops_m.emplace_back(x, y);
  }
  if (!good || !reader.at_end()) return std::nullopt;
  return state;
}

}  // namespace sleight::worlds::spelling
