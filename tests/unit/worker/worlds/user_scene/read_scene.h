// Reads scenes for tests.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "common/request/direction_request.h"
#include "worker/worlds/user_scene/build.h"
#include "worker/worlds/user_scene/request.h"

namespace sleight::worlds::user_scene {

inline base::Result<request::DirectionRequest, std::vector<request::Diagnostic>> read_scene(
    std::string_view text) {
  const std::vector<request::WorldBinding> worlds{request_binding()};
  return request::read_request(text, "s.toml", worlds);
}

/// Reads the text behind the lines `[world]` and `name = "scene"`. REQUIRES: it has no errors.
inline Parameters parameters_of(const std::string& text) {
  const auto request = read_scene("[world]\nname = \"scene\"\n" + text);
  if (!request) base::check_failed("the scene has no errors", to_string(request.error().front()));
  return request::parameters_of<Parameters>(request.value());
}
inline SceneDescription scene_of(const std::string& text) {
  return parameters_of(text).scene;
}

inline BuiltScene built_scene(const SceneDescription& description) {
  auto built = build(description);
  CHECK(built.ok());
  return std::move(built).value();
}

}  // namespace sleight::worlds::user_scene
