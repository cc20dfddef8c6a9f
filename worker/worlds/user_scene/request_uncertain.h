// Binds [[world.uncertain]] of a scene. Private to this folder.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "common/request/binder.h"
#include "worker/worlds/user_scene/parameters.h"
#include "worker/worlds/user_scene/request_body.h"

namespace sleight::worlds::user_scene {

/// Finds the objects of a built scene by name.
class ObjectNames {
 public:
  /// REQUIRES: `scene` and `built` outlive this object.
  ObjectNames(const SceneDescription& scene, const BuiltScene& built)
      : scene_(scene), built_(built) {}

  /// Returns the object with this name, or all copies of the body with this name. If there is
  /// none, reports an error that suggests the nearest name. If `must_move`, reports an error if an
  /// object doesn't move, and returns none.
  std::vector<std::uint32_t> find(request::Binder& table, std::string_view key,
                                  const std::string& name, bool must_move) const;
  /// Binds the keys `body` and `bodies`, and returns the names. The table must not have both.
  static std::vector<std::string> bind(request::Binder& table);
  /// Returns the moving bodies with these names. Reports an error if one is named twice.
  std::vector<std::uint32_t> find_all(request::Binder& table,
                                      const std::vector<std::string>& names) const;

  const BuiltScene& built() const { return built_; }
  const Object& object(std::uint32_t number) const { return built_.objects[number]; }
  const BodyDescription& described(std::uint32_t number) const {
    return scene_.bodies[object(number).description];
  }

 private:
  const SceneDescription& scene_;
  const BuiltScene& built_;
};

/// `objects` is null if the scene has errors; then names aren't looked up.
void bind_uncertain(request::Binder& world, Parameters& parameters, const ObjectNames* objects,
                    const NameList& materials);

}  // namespace sleight::worlds::user_scene
