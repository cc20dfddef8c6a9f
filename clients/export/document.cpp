#include "clients/export/document.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include <fmt/format.h>

#include "clients/export/keys.h"
#include "clients/export/look.h"
#include "clients/plot/text.h"
#include "common/base/check.h"
#include "common/json/value.h"
#include "common/math/elementary.h"

namespace sleight::gltf {
namespace {

using Json = json::Value;
using scene::FeatureKind;

/// Roughness of a material without shine, which reflects evenly in all directions.
constexpr double k_roughness = 0.6;

/// Makes text printable line by line.
std::string clean_text(const std::string& text) {
  std::string clean;
  std::size_t begin = 0;
  while (true) {
    const std::size_t end = text.find('\n', begin);
    clean += plot::printable(std::string_view(text).substr(begin, end - begin));
    if (end == std::string::npos) return clean;
    clean += '\n';
    begin = end + 1;
  }
}

Json json_of(double number) {
  return std::isfinite(number) ? Json(number) : Json(nullptr);
}

Json json_of(const Extras& extras) {
  Json json = Json::object();
  for (const Extra& extra : extras) {
    Json& value = json[plot::printable(extra.key)];
    if (const auto* number = std::get_if<double>(&extra.value)) {
      value = json_of(*number);
    } else if (const auto* text = std::get_if<std::string>(&extra.value)) {
      value = clean_text(*text);
    } else if (const auto* numbers = std::get_if<std::vector<double>>(&extra.value)) {
      value = Json::array();
      for (const double one : *numbers)
        value.push_back(json_of(one));
    } else if (const auto* whole = std::get_if<std::int64_t>(&extra.value)) {
      value = *whole;
    } else {
      value = std::get<bool>(extra.value);
    }
  }
  return json;
}

/// Converts from screen colours (IEC 61966-2-1) to glTF's linear colours. Four digits are finer
/// than the steps of an 8-bit channel.
double linear(std::uint8_t channel) {
  const double share = channel / 255.0;
  const double value = share <= 0.04045 ? share / 12.92 : math::pow((share + 0.055) / 1.055, 2.4);
  return std::round(1e4 * value) / 1e4;
}

Json json_of(const Material& material) {
  const plot::Color& color = material.color;
  Json json{{"name", material.name},
            {"pbrMetallicRoughness",
             {{"baseColorFactor",
               {linear(color.red), linear(color.green), linear(color.blue), color.opacity}},
              {"metallicFactor", 0},
              {"roughnessFactor", k_roughness}}}};
  if (color.opacity < 1) json["alphaMode"] = "BLEND";
  if (material.is_double_sided) json["doubleSided"] = true;
  return json;
}

/// A look of a scene feature. Some of the animations share this look.
struct Shown {
  std::uint32_t feature = 0;
  Look look{};
  std::vector<bool> in{};  ///< by clip
};

std::size_t first_in(const Shown& shown) {
  return static_cast<std::size_t>(std::ranges::find(shown.in, true) - shown.in.begin());
}

/// Returns all looks, by feature and then by the first clip with the look.
std::vector<Shown> all_shown(const Document& document) {
  std::vector<Shown> all;
  const auto features = static_cast<std::uint32_t>(document.scene.features.size());
  const std::uint32_t bodies = document.scene.bodies();
  for (std::uint32_t feature = 0; feature < features; ++feature) {
    const std::size_t first = all.size();
    for (std::size_t i = 0; i < document.clips.size(); ++i) {
      const Clip& clip = document.clips[i];
      const bool is_body = feature < bodies;
      if (is_body && !clip.motion.path(feature).enters()) continue;
      Look look = look_of(document.scene, feature, clip.own, clip.offsets_m);
      if (look.empty() && !is_body) continue;
      auto same = std::find_if(all.begin() + static_cast<std::ptrdiff_t>(first), all.end(),
                               [&](const Shown& shown) { return shown.look == look; });
      if (same == all.end()) {
        all.push_back({.feature = feature,
                       .look = std::move(look),
                       .in = std::vector<bool>(document.clips.size())});
        same = std::prev(all.end());
      }
      same->in[i] = true;
    }
  }
  return all;
}

class Assembler {
 public:
  Assembler(const Document& document, const Options& options)
      : document_(document), options_(options), shown_(all_shown(document)) {}

  base::Result<Glb, std::string> assemble() {
    const std::size_t channels = most_channels();
    if (channels > k_channels_max) {
      return fmt::format(
          "and the animations exported with it need up to {} channels in one file, above the "
          "maximum of {}; export fewer animations together, or one file per animation",
          channels, k_channels_max);
    }
    for (const Clip& clip : document_.clips) {
      if (std::string fault = add_keys(clip); !fault.empty()) return fault;
    }
    json_["asset"] = {{"version", "2.0"}, {"generator", "Sleight"}};
    if (!document_.extras.empty()) json_["asset"]["extras"] = json_of(document_.extras);
    json_["scene"] = 0;
    json_["scenes"] = Json::array({Json::object()});
    for (std::size_t node = 0; node < shown_.size(); ++node)
      add_node(node);
    for (std::size_t clip = 0; clip < document_.clips.size(); ++clip)
      add_clip(clip);
    return writer_.finish(std::move(json_));
  }

 private:
  std::size_t most_channels() const {
    std::size_t in_each = 0;
    for (const Shown& shown : shown_)
      in_each += (is_body(shown) ? 2 : 0) + (std::ranges::count(shown.in, false) > 0 ? 1 : 0);
    return in_each * document_.clips.size();
  }

  std::string add_keys(const Clip& clip) {
    auto& keys = keys_.emplace_back(document_.scene.bodies());
    for (const motion::Path& path : clip.motion.paths()) {
      if (!path.enters()) continue;
      auto made = keys_of(path, clip.motion.end_s(), options_.fps);
      if (!made) return made.error();
      keys[path.body()] = std::move(made).value();
    }
    return {};
  }

  std::string name_of(const Shown& shown) const {
    const std::string name = plot::printable(document_.scene.features[shown.feature].name);
    const auto looks = std::ranges::count(shown_, shown.feature, &Shown::feature);
    if (looks == 1) return name;
    return fmt::format("{} ({})", name, plot::printable(document_.clips[first_in(shown)].name));
  }

  bool is_body(const Shown& shown) const {
    return document_.scene.features[shown.feature].kind == FeatureKind::body;
  }

  /// Whether the scale is animated. It is if some clip shows the thing only part of the time.
  bool comes_and_goes(const Shown& shown) const {
    for (std::size_t clip = 0; clip < shown.in.size(); ++clip) {
      if (!shown.in[clip] || (is_body(shown) && keys_[clip][shown.feature].enters_s > 0))
        return true;
    }
    return false;
  }

  void add_node(std::size_t number) {
    const Shown& shown = shown_[number];
    Json node{{"name", name_of(shown)}};
    if (!shown.look.empty()) node["mesh"] = add_mesh(shown);
    const std::size_t first = first_in(shown);
    if (is_body(shown)) {
      const BodyKeys& keys = keys_[first][shown.feature];
      node["translation"] = keys.translation.values.front();
      node["rotation"] = keys.rotation.values.front();
    }
    if (first > 0) node["scale"] = k_hidden;
    const auto kind = static_cast<std::size_t>(document_.scene.features[shown.feature].kind);
    node["extras"] = {{"kind", scene::k_kind_names[kind]}};
    put_node(std::move(node));
  }

  std::size_t put_node(Json node) {
    const std::size_t number = json_["nodes"].size();
    json_["nodes"].push_back(std::move(node));
    json_["scenes"][0]["nodes"].push_back(number);
    return number;
  }

  std::size_t add_mesh(const Shown& shown) {
    Json primitives = Json::array();
    for (const Primitive& primitive : shown.look) {
      primitives.push_back({{"attributes",
                             {{"POSITION", writer_.add_positions(primitive.places)},
                              {"NORMAL", writer_.add_normals(primitive.normals)}}},
                            {"indices", writer_.add_indices(primitive.corners)},
                            {"material", add_material(primitive.material)}});
    }
    // Equal bodies of one colour, such as dice, share a mesh.
    const auto known = std::ranges::find(meshes_, primitives);
    if (known != meshes_.end()) return static_cast<std::size_t>(known - meshes_.begin());
    meshes_.push_back(primitives);
    json_["meshes"].push_back({{"name", name_of(shown)}, {"primitives", std::move(primitives)}});
    return meshes_.size() - 1;
  }

  std::size_t add_material(const Material& material) {
    const auto known = std::ranges::find(materials_, material);
    if (known != materials_.end()) return static_cast<std::size_t>(known - materials_.begin());
    materials_.push_back(material);
    json_["materials"].push_back(json_of(material));
    return materials_.size() - 1;
  }

  void add_clip(std::size_t number) {
    const Clip& clip = document_.clips[number];
    Json animation{{"name", plot::printable(clip.name)},
                   {"samplers", Json::array()},
                   {"channels", Json::array()}};
    for (std::size_t node = 0; node < shown_.size(); ++node)
      add_channels(node, number, animation);
    // glTF doesn't allow a clip without a channel.
    if (animation["channels"].empty()) {
      const std::size_t node = put_node({{"name", plot::printable(clip.name)}});
      add_steps(node, {.times_s = {0}, .values = {k_shown}}, animation);
    }
    if (!clip.extras.empty()) animation["extras"] = json_of(clip.extras);
    json_["animations"].push_back(std::move(animation));
  }

  void add_channels(std::size_t node, std::size_t clip, Json& animation) {
    const Shown& shown = shown_[node];
    const bool is_there = shown.in[clip];
    float enters_s = 0;
    if (is_there && is_body(shown)) {
      const BodyKeys& keys = keys_[clip][shown.feature];
      enters_s = keys.enters_s;
      add_channel(node, "translation", keys.translation, "LINEAR", animation);
      add_channel(node, "rotation", keys.rotation, "LINEAR", animation);
    }
    if (!comes_and_goes(shown)) return;
    Channel<Float3> steps{.times_s = {0}, .values = {k_shown}};
    if (!is_there) steps.values = {k_hidden};
    if (enters_s > 0) steps = {.times_s = {0, enters_s}, .values = {k_hidden, k_shown}};
    add_steps(node, steps, animation);
  }

  void add_steps(std::size_t node, const Channel<Float3>& steps, Json& animation) {
    add_channel(node, "scale", steps, "STEP", animation);
  }

  template <class Value>
  void add_channel(std::size_t node, const char* path, const Channel<Value>& channel,
                   const char* interpolation, Json& animation) {
    const std::size_t sampler = animation["samplers"].size();
    animation["samplers"].push_back(
        {{"input", writer_.add_times(channel.times_s)},
         {"output", writer_.add_values(std::span<const Value>(channel.values))},
         {"interpolation", interpolation}});
    animation["channels"].push_back(
        {{"sampler", sampler}, {"target", {{"node", node}, {"path", path}}}});
  }

  const Document& document_;
  const Options& options_;
  std::vector<Shown> shown_;
  std::vector<std::vector<BodyKeys>> keys_{};  ///< by clip and body; empty if the body never enters
  GlbWriter writer_{};
  std::vector<Material> materials_{};
  std::vector<Json> meshes_{};  ///< each mesh's primitives
  Json json_{};
};

}  // namespace

base::Result<Glb, std::string> glb_of(const Document& document, const Options& options) {
  for (const Clip& clip : document.clips)
    CHECK_EQ(clip.motion.bodies(), document.scene.bodies());
  return Assembler(document, options).assemble();
}

}  // namespace sleight::gltf
