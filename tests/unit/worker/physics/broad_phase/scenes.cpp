#include "tests/unit/worker/physics/broad_phase/scenes.h"

#include <cmath>
#include <limits>

namespace sleight::physics {
namespace {

using Point = std::array<double, 3>;

Box around(const Point& centre, const Point& half) {
  Box box;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    box.low_m[axis] = static_cast<float>(centre[axis] - half[axis]);
    box.high_m[axis] = static_cast<float>(centre[axis] + half[axis]);
  }
  return box;
}

Box cube(const Point& centre, double edge) {
  return around(centre, {edge / 2, edge / 2, edge / 2});
}

Point in_cube(Dice& dice, double half) {
  return {dice.between(-half, half), dice.between(-half, half), dice.between(-half, half)};
}

/// Moves a box by a small step and changes its size slightly. One time in twelve, returns a new box
/// elsewhere.
template <Box (*Fresh)(Dice&)>
Box step(Dice& dice, const Box& box) {
  if (dice.once_in(12)) return Fresh(dice);
  if (dice.once_in(12)) return box;
  Box next;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double low = double{box.low_m[axis]};
    const double edge = double{box.high_m[axis]} - low;
    const double grown = edge * dice.between(0.7, 1.4);
    next.low_m[axis] = static_cast<float>(low + edge * dice.between(-0.3, 0.3));
    next.high_m[axis] =
        std::max(next.low_m[axis], static_cast<float>(double{next.low_m[axis]} + grown));
    if (grown > 8 || !std::isfinite(grown)) return Fresh(dice);
  }
  return next;
}

template <Box (*Fresh)(Dice&)>
Box again(Dice& dice, const Box& box) {
  return dice.once_in(8) ? box : Fresh(dice);
}

Box gas(Dice& dice) {
  return cube(in_cube(dice, 2), dice.between(0.7, 1.3));
}

/// A box that is stretched along one axis. Box sizes are on both sides of the grid's borders
/// between levels.
Box stretched(Dice& dice) {
  const double edge = dice.between(0.7, 1.1);
  Point half = {edge / 2, edge / 2, edge / 2};
  half[dice.below(3)] = edge / 2 * dice.between(1, 4);
  return around(in_cube(dice, 3), half);
}

Box corners(Dice& dice) {
  Point centre{};
  for (double& x : centre) {
    const double away = dice.between(0, 1);
    x = (dice.once_in(2) ? 20 : -20) + away * away * away;
  }
  return cube(centre, 0.5);
}

Box pile(Dice& dice) {
  return cube({dice.between(-4, 4), dice.between(-4, 4), dice.between(0, 0.05)}, 1.3);
}

Box six_decades(Dice& dice) {
  const double edge = std::ldexp(dice.between(1, 2), static_cast<int>(dice.below(20)) - 10);
  // Some boxes are near the centre, so that small boxes meet too.
  const double spread = std::ldexp(1.0, static_cast<int>(dice.below(20)) - 10);
  return around(in_cube(dice, spread), {edge / 2, edge / 2 * dice.between(0.01, 1), edge / 2});
}

/// Points, plates and boxes. Coordinates are integers, so many boxes touch exactly. Both zeros
/// occur.
Box touching(Dice& dice) {
  Box box;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    box.low_m[axis] = static_cast<float>(dice.below(8)) - 4;
    box.high_m[axis] = box.low_m[axis] + static_cast<float>(dice.below(3));
    if (box.low_m[axis] == 0 && dice.once_in(2)) box.low_m[axis] = -0.0F;
    if (box.high_m[axis] == 0 && box.low_m[axis] < 0 && dice.once_in(2)) box.high_m[axis] = -0.0F;
  }
  return box;
}

Box with_infinite(Dice& dice) {
  constexpr float k_infinite = std::numeric_limits<float>::infinity();
  constexpr float k_greatest = std::numeric_limits<float>::max();
  Box box = gas(dice);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (dice.once_in(6)) box.low_m[axis] = dice.once_in(2) ? -k_infinite : -k_greatest;
    if (dice.once_in(6)) box.high_m[axis] = dice.once_in(2) ? k_infinite : k_greatest;
    if (dice.once_in(25)) box.low_m[axis] = box.high_m[axis];
  }
  return box;
}

/// Small boxes up to a thousand kilometres from the origin. Many boxes share a few places.
Box far(Dice& dice) {
  Point centre{};
  for (double& x : centre)
    x = (static_cast<double>(dice.below(3)) - 1) * 1e6 + dice.between(-0.5, 0.5);
  return cube(centre, dice.once_in(3) ? 1 : 1e-3);
}

/// A random point: on each axis, in one of five periods. The periods are 5, 4 and 3 m long.
Point in_periods(Dice& dice, double half) {
  Point centre = in_cube(dice, half);
  const Point period = {5, 4, 3};
  for (std::size_t axis = 0; axis < 3; ++axis)
    centre[axis] += period[axis] * (static_cast<double>(dice.below(5)) - 2);
  return centre;
}

Box periodic_gas(Dice& dice) {
  return cube(in_periods(dice, 2), dice.between(0.6, 1.2));
}

/// Points and boxes. Some boxes are larger than the whole period, and some are thousands of images
/// away.
Box periodic_any(Dice& dice) {
  Point centre = in_periods(dice, 2);
  if (dice.once_in(5)) centre[dice.below(3)] += 60 * (static_cast<double>(dice.below(2001)) - 1e3);
  Point half{};
  for (double& edge : half)
    edge = dice.once_in(4) ? 0 : std::ldexp(dice.between(0.5, 1), -static_cast<int>(dice.below(7)));
  if (dice.once_in(20)) half[dice.below(3)] = dice.between(1.4, 4);
  if (dice.once_in(40)) half[dice.below(3)] = 1e30;
  return around(centre, half);
}

}  // namespace

const std::vector<Scene>& scenes() {
  static const std::vector<Scene> all = {
      {"gas", {}, 1, gas, step<gas>},
      {"gas, far too small a size given", {}, 1e-3, gas, step<gas>},
      {"gas, far too great a size given", {}, 1e6, gas, step<gas>},
      {"corners", {}, 0.5, corners, step<corners>},
      {"pile", {}, 1.3, pile, step<pile>},
      {"six decades", {}, 1, six_decades, again<six_decades>},
      {"touching", {}, 2, touching, again<touching>},
      {"infinite", {}, 1, with_infinite, step<with_infinite>},
      {"far", {}, 1e-3, far, again<far>},
      {"periodic gas, 1 axis", {5, 0, 0}, 1, periodic_gas, step<periodic_gas>},
      {"periodic gas, 2 axes", {0, 4, 3}, 1, periodic_gas, step<periodic_gas>},
      {"periodic gas, 3 axes", {5, 4, 3}, 1, periodic_gas, step<periodic_gas>},
      {"periodic, any size", {5, 4, 3}, 0.3, periodic_any, again<periodic_any>},
      {"periodic, any size, 2 axes", {5, 0, 3}, 0.3, periodic_any, again<periodic_any>},
      {"periodic, touching", {8, 8, 8}, 2, touching, again<touching>},
      {"stretched", {}, 1, stretched, step<stretched>},
      {"stretched, anywhere else each time", {}, 1, stretched, again<stretched>},
      {"periodic, stretched", {6, 7, 8}, 1, stretched, step<stretched>},
      {"periodic, far too small a size given", {5, 4, 3}, 0.002, periodic_gas, step<periodic_gas>},
  };
  return all;
}

}  // namespace sleight::physics
