// A strip of pictures side by side. Each picture shows one moment of a scene's simulation.
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

/// The first picture shows the start. The last picture shows the end of the setting's duration.
Strip strip_of(const physics::scenes::Setting& setting, const std::string& title);

}  // namespace sleight::scene_pictures
