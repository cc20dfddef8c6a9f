// The simulator's time: whole ticks of 2^-30 seconds, about 0.93 ns.
//
// Idea. Time is an integer, so rounding can't decide whether two events are simultaneous. A time
// span in ticks converts to seconds exactly (up to 2^53 ticks, 97 days), and adding spans is exact.
// So if a scene starts n ticks later, its events are the same n ticks later, bit for bit. Thread
// safety: values.
#pragma once

#include <compare>
#include <cstdint>
#include <limits>

namespace sleight::physics {

using TickCount = std::int64_t;

/// A point in time, counted from the start of the simulation.
struct Tick {
  TickCount value = 0;
  friend constexpr auto operator<=>(Tick, Tick) = default;
  friend constexpr Tick operator+(Tick t, TickCount span) { return {t.value + span}; }
  friend constexpr Tick operator-(Tick t, TickCount span) { return {t.value - span}; }
  friend constexpr TickCount operator-(Tick a, Tick b) { return a.value - b.value; }
};

inline constexpr double k_seconds_per_tick = 0x1p-30;
inline constexpr double k_ticks_per_second = 0x1p30;

/// Last tick that a simulation may reach: 2^52 ticks, 48 days.
inline constexpr Tick k_tick_max{TickCount{1} << 52};
/// Tick of events that never happen, later than all ticks of a simulation.
inline constexpr Tick k_never{std::numeric_limits<TickCount>::max()};

/// Longer than every time span. Used for motions that don't end.
inline constexpr double k_forever_s = std::numeric_limits<double>::infinity();

/// Exact. REQUIRES: |span| <= 2^53.
constexpr double seconds(TickCount span) {
  return static_cast<double>(span) * k_seconds_per_tick;
}

/// Converts a time span to ticks, rounded down. The result's magnitude is at most k_tick_max.
/// REQUIRES: not NaN.
constexpr TickCount ticks_before(double span_s) {
  const double ticks = span_s * k_ticks_per_second;
  if (ticks >= static_cast<double>(k_tick_max.value)) return k_tick_max.value;
  if (ticks <= -static_cast<double>(k_tick_max.value)) return -k_tick_max.value;
  const auto whole = static_cast<TickCount>(ticks);  // towards zero
  return static_cast<double>(whole) > ticks ? whole - 1 : whole;
}

/// Converts a time span to ticks, rounded up. The result's magnitude is at most k_tick_max.
/// REQUIRES: not NaN.
constexpr TickCount ticks_after(double span_s) {
  return -ticks_before(-span_s);
}

}  // namespace sleight::physics
