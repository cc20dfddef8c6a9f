// Binds the parts of a scene's request, and resolves names. Private to this folder.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "common/request/direction_request.h"
#include "worker/worlds/user_scene/parameters.h"

namespace sleight::worlds::user_scene {

inline constexpr std::size_t k_name_characters_max = 64;
inline constexpr double k_friction_max = 100;
inline constexpr double k_far_mm = 1e6;

/// Options of lengths, times and names.
inline request::NumberOptions in_mm(std::string_view help, double minimum_mm = -k_far_mm) {
  return {.minimum = minimum_mm, .maximum = k_far_mm, .unit = "mm", .help = help};
}
inline request::NumberOptions in_s(std::string_view help, double minimum_s = 0) {
  return {.minimum = minimum_s, .maximum = 3600, .unit = "s", .help = help};
}
inline request::TextOptions a_name(std::string_view help) {
  return {.characters_max = k_name_characters_max, .help = help};
}

/// Says that no `what` has this name, and suggests the nearest one, or lists all if they are few.
std::string unknown(std::string_view what, const std::string& name,
                    const std::vector<std::string>& names);

/// Distinct names, and their numbers in the order in which they were added.
class NameList {
 public:
  explicit NameList(std::string_view what) : what_(what) {}

  /// Adds a name that must be new and not empty. Otherwise reports an error at the key.
  void add(request::Binder& table, std::string_view key, const std::string& name);
  /// Returns a name's number. If the name is unknown, reports an error that suggests the nearest,
  /// and returns 0.
  std::uint32_t find(request::Binder& table, std::string_view key, const std::string& name) const;
  /// Returns a name's number. Adds the name if it is new.
  std::uint32_t number(const std::string& name);
  const std::vector<std::string>& all() const { return names_; }

 private:
  std::string_view what_;  ///< "material"
  std::vector<std::string> names_;
};

struct Names {
  NameList materials{"material"};
  NameList groups{"group"};
  NameList objects{"body"};
  std::size_t triangles = 0;  ///< of all meshes and channels so far
};

void bind_bodies(request::Binder& world, SceneDescription& scene, Names& names);

/// Binds the keys `body` and `bodies`, and returns the names. The table must not have both.
std::vector<std::string> bind_body_names(request::Binder& table);

/// Returns the object with this name, or all copies of the body with this name. If there is none,
/// reports an error that suggests the nearest name. REQUIRES: the scene is built.
std::vector<std::uint32_t> find_objects(request::Binder& table, std::string_view key,
                                        const std::string& name, const Parameters& parameters);
/// Returns the moving bodies with the names of bind_body_names(). Reports an error if one doesn't
/// move or is named twice. REQUIRES: the scene is built.
std::vector<std::uint32_t> find_moving(request::Binder& table,
                                       const std::vector<std::string>& names,
                                       const Parameters& parameters);

/// Binds [[world.uncertain]]. If the scene isn't built, bodies aren't looked up.
void bind_uncertain(request::Binder& world, const NameList& materials, Parameters& parameters);

/// Binds [[world.region]] and [constraint]. If the scene isn't built, constraints aren't made.
void bind_constraints(request::WorldSections& sections, Parameters& parameters);

}  // namespace sleight::worlds::user_scene
