// Writes animations of a scene as one glTF 2.0 binary file (.glb).
//
// A file has a node for each scene feature, named after it ("die 3"), and a clip (glTF's
// "animation") for each animation. A body's node has the channels translation and rotation
// (keys.h). A node's scale is 0 while the thing is absent: for example, before a body enters.
//
// Several animations in one file share a node if they look alike. A thing that differs (a table's
// heights, moved vertices) has a node for each look, named after the first animation with it:
// "table (c0.250)". Each clip shows only its own look, by setting nodes' scales to 1 or 0. A body
// that never enters has no node. If another animation has a node for it, the scale is 0.
//
//   1. Same input, same bytes.
//   2. Names and texts are made valid UTF-8 without control characters, and the JSON is ASCII.
//   3. The pose without animation is the beginning of the first animation.
//
// The document's extras are stored in `asset`, a clip's extras in the clip. The extras of a node
// contain its kind ("body", "fixed", "wanted"). Axes: axes.h. The namespace differs from the
// folder's name because `export` is a keyword. Pure functions.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "clients/export/glb.h"
#include "common/base/result.h"
#include "common/motion/path.h"
#include "common/scene/scene.h"

namespace sleight::gltf {

/// A list holds numbers that belong together, such as an outcome of several elements.
using ExtraValue = std::variant<bool, std::int64_t, double, std::string, std::vector<double>>;

struct Extra {
  std::string key{};
  ExtraValue value{};
};

/// Metadata of a file or clip, written in this order. NaN and infinity become null, because JSON
/// lacks them. Text is made valid UTF-8 without control characters except line breaks.
using Extras = std::vector<Extra>;

struct Clip {
  std::string name{};  ///< such as "c0.250"
  motion::Animation motion{};
  scene::Variation own{};
  std::vector<math::Vec3> offsets_m{};  ///< of the scene description's vertices
  Extras extras{};
};

struct Document {
  scene::Scene scene{};
  std::vector<Clip> clips{};
  Extras extras{};
};

struct Options {
  /// If set, keys are only on whole frames. None: keys are chosen as in keys.h.
  std::optional<double> fps{};
};

/// Maximum channels of a file. A thing that only some clips show has a channel in each clip, so
/// channels grow with the square of the clips. The limit allows 500 clips that each have their own
/// table.
inline constexpr std::size_t k_channels_max = 250'000;

/// Returns the file, or an error text that follows the file's name: too many keys, channels or
/// bytes.
/// REQUIRES: a valid scene description (scene::fault_of); each clip has all its bodies and a valid
/// variation; fps in (0, k_fps_max].
base::Result<Glb, std::string> glb_of(const Document& document, const Options& options = {});

}  // namespace sleight::gltf
