#include "worker/worlds/spelling/pouring.h"

#include <utility>

namespace sleight::worlds::spelling {

Pouring no_balls(const Spelling& world, std::vector<Vec3> offsets_m) {
  State state{.offsets_m = std::move(offsets_m),
              .active = std::vector<std::uint8_t>(world.balls(), 0),
              .drops_m = std::vector<Vec2>(world.balls(), Vec2(0, 0))};
  Outcome outcome = world.simulate(state);
  return {.state = std::move(state), .outcome = std::move(outcome)};
}

Pouring with_ball(const Spelling& world, const Pouring& pouring, std::size_t ball,
                  const Vec2& drop_m) {
  State state = pouring.state;
  state.active[ball] = 1;
  state.drops_m[ball] = drop_m;
  Outcome outcome = world.simulate_from(state, pouring.state, pouring.outcome);
  return {.state = std::move(state), .outcome = std::move(outcome)};
}

}  // namespace sleight::worlds::spelling
