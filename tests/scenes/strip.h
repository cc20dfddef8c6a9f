// A strip of pictures of a scene: some moments of its simulation, side by side.
//
// Thread safety: pure functions.
#pragma once

#include <cstddef>
#include <string>

#include "tests/scenes/shared/scenes.h"

namespace sleight::scene_pictures {

inline constexpr std::size_t k_moments = 5;

struct Strip {
  std::string svg;
  std::string error;     ///< the error that ended the simulation early, if any
  bool refused = false;  ///< the error is the scene's fault
};

/// The first moment is the start; the last is the setting's duration.
Strip strip_of(const physics::scenes::Setting& setting, const std::string& title);

}  // namespace sleight::scene_pictures
