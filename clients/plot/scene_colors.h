// The colours of scene features, shared by pictures and exported models. Thread-safe as any value.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "clients/plot/figure.h"

namespace sleight::plot::scene_colors {

inline constexpr Color k_table{0xF6, 0xF4, 0xEF};
inline constexpr Color k_fixed{0xD5, 0xD5, 0xD5};  ///< fixed things: their highest pieces
inline constexpr Color k_ivory{0xFF, 0xFD, 0xF5};  ///< dice
inline constexpr Color k_ring{0xC4, 0x12, 0x30};   ///< a goal of one body; no body has this colour
inline constexpr Color k_tint{0xF4, 0xB8, 0xA0};   ///< a goal of any body

/// Maximum bodies with distinct hues. If there are more, colours depend on the bodies' order.
inline constexpr std::uint32_t k_hues = 6;

/// Returns a colour of the viridis map; `share` is from 0 (first body) to 1 (last). The map's
/// lightness increases evenly for people with common colour blindnesses and in grey prints.
inline Color in_order(double share) {
  constexpr std::array<std::array<double, 3>, 5> k_stops = {
      {{68, 1, 84}, {59, 82, 139}, {33, 145, 140}, {94, 201, 98}, {253, 231, 37}}};
  const double at = std::clamp(share, 0.0, 1.0) * (k_stops.size() - 1);
  const auto low = std::min(static_cast<std::size_t>(at), k_stops.size() - 2);
  const double part = at - static_cast<double>(low);
  const auto channel = [&](std::size_t i) {
    return static_cast<std::uint8_t>(
        std::lround((1 - part) * k_stops[low][i] + part * k_stops[low + 1][i]));
  };
  return {channel(0), channel(1), channel(2)};
}

inline Color of_body(std::uint32_t body, std::uint32_t bodies) {
  if (bodies <= k_hues) return palette::series(body);
  return in_order(static_cast<double>(body) / static_cast<double>(bodies - 1));
}

}  // namespace sleight::plot::scene_colors
