// Animations of a scene as one glTF 2.0 binary file (.glb).
//
// A file holds a node for each feature, with the feature's name ("die 3"), and a clip (glTF's
// "animation") for each animation. A body's node has the channels translation and rotation
// (keys.h). Scale says whether a thing is there: a body that enters later has the scale 0 until it
// enters, by a channel of steps.
//
// Several animations in one file share a node where they look alike. What differs (a table's
// heights, vertices that were moved) has a node for each look, called "table (c0.250)" by the first
// animation that has it, and each clip shows its own by steps of scale. A body that never enters
// has no node; where another animation has it, its scale is 0 in the clip.
//
// 1. Same input, same bytes.
// 2. Names and texts are made valid UTF-8 without control characters, and the file's JSON is ASCII.
// 3. What is not animated is the first animation as it begins.
//
// The document's extras are those of `asset`, a clip's its own. Each node says its kind ("body",
// "fixed", "wanted") in its extras. Axes: axes.h. (The namespace is not the folder's name, as
// `export` is a word of the language.)
//
// Pure functions.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "clients/export/extras.h"
#include "clients/export/glb.h"
#include "common/base/result.h"
#include "common/motion/path.h"
#include "common/scene/scene.h"

namespace sleight::gltf {

struct Clip {
  std::string name{};  ///< "c0.250"
  motion::Animation motion{};
  scene::Variation own{};
  std::vector<math::Vec3> offsets_m{};  ///< of the scene's vertices
  Extras extras{};
};

struct Document {
  scene::Scene scene{};
  std::vector<Clip> clips{};
  Extras extras{};
};

struct Options {
  /// Keys on whole frames and nowhere else, instead of those that keys.h says.
  std::optional<double> fps{};
};

/// Of a file: what shows in some clips only has a channel in each, so they grow with the square of
/// the clips: five hundred of those with a table each.
inline constexpr std::size_t k_channels_max = 250'000;

/// The file; or why there is none, as a predicate: too many keys, channels or bytes.
/// REQUIRES: a sound scene (scene::fault_of); each clip of all its bodies, variations sound; fps in
/// (0, k_fps_max].
base::Result<Glb, std::string> glb_of(const Document& document, const Options& options = {});

}  // namespace sleight::gltf
