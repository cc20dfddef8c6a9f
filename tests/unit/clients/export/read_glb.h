// Reads .glb files and plays their animations, for tests. The code follows the specification
// (Khronos Group, "glTF 2.0 Specification") and uses none of the exporter's code.
//
// All functions are pure and report faults as GoogleTest failures.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <span>
#include <string>
#include <vector>

#include "common/json/value.h"
#include "common/math/rotation.h"

namespace sleight::gltf::testing {

using Json = json::Value;

struct File {
  Json json{};
  std::string text{};  ///< of the JSON
  std::string binary{};
};

inline std::uint32_t word_at(const std::string& bytes, std::size_t offset) {
  std::uint32_t word = 0;
  for (std::size_t i = 0; i < 4; ++i)
    word |= static_cast<std::uint32_t>(static_cast<unsigned char>(bytes.at(offset + i))) << (8 * i);
  return word;
}

inline File read_glb(const std::string& bytes) {
  File file;
  EXPECT_EQ(bytes.substr(0, 4), "glTF");
  EXPECT_EQ(word_at(bytes, 4), 2U);
  EXPECT_EQ(word_at(bytes, 8), bytes.size());
  const std::uint32_t json_bytes = word_at(bytes, 12);
  EXPECT_EQ(bytes.substr(16, 4), "JSON");
  EXPECT_EQ(json_bytes % 4, 0U);
  file.text = bytes.substr(20, json_bytes);
  file.json = Json::parse(file.text);
  const std::size_t rest = 20 + json_bytes;
  if (rest == bytes.size()) return file;
  EXPECT_EQ(bytes.substr(rest + 4, 4), std::string("BIN\0", 4));
  EXPECT_EQ(word_at(bytes, rest) % 4, 0U);
  file.binary = bytes.substr(rest + 8);
  EXPECT_EQ(word_at(bytes, rest), file.binary.size());
  return file;
}

inline std::vector<std::vector<double>> vectors_of(const File& file, const Json& accessor) {
  const Json& what = file.json["accessors"].at(accessor.get<std::size_t>());
  const Json& view = file.json["bufferViews"].at(what["bufferView"].get<std::size_t>());
  const std::string type = what["type"].text();
  const std::size_t width = type == "SCALAR" ? 1 : static_cast<std::size_t>(type.back() - '0');
  const int component = what["componentType"].get<int>();
  const std::size_t size = component == 5123 ? 2 : 4;
  EXPECT_EQ(view["byteOffset"].get<std::size_t>() % 4, 0U);
  EXPECT_EQ(view["byteLength"].get<std::size_t>(), what["count"].get<std::size_t>() * width * size);
  std::vector<std::vector<double>> vectors(what["count"].get<std::size_t>());
  std::size_t at = view["byteOffset"].get<std::size_t>();
  for (std::vector<double>& vector : vectors) {
    for (std::size_t i = 0; i < width; ++i, at += size) {
      if (component == 5126) {
        float number = 0;
        std::memcpy(&number, &file.binary.at(at + 3) - 3, 4);
        vector.push_back(static_cast<double>(number));
      } else {
        std::uint32_t index = 0;
        for (std::size_t byte = size; byte-- > 0;)
          index = (index << 8) | static_cast<unsigned char>(file.binary.at(at + byte));
        vector.push_back(index);
      }
    }
  }
  return vectors;
}

/// Checks that all accessors are used, bounds match the numbers, numbers are finite, and times
/// ascend.
inline void expect_sound(const File& file) {
  const auto listed = [&](const char* name) {
    return file.json.value(name, Json::array()).elements();
  };
  std::vector<int> uses(listed("accessors").size());
  const auto use = [&](const Json& accessor) { ++uses.at(accessor.get<std::size_t>()); };
  for (const Json& mesh : listed("meshes")) {
    for (const Json& primitive : mesh["primitives"].elements()) {
      use(primitive["attributes"]["POSITION"]);
      use(primitive["attributes"]["NORMAL"]);
      use(primitive["indices"]);
      const std::size_t count = vectors_of(file, primitive["attributes"]["POSITION"]).size();
      for (const auto& index : vectors_of(file, primitive["indices"]))
        EXPECT_LT(index[0], count);
      EXPECT_EQ(vectors_of(file, primitive["attributes"]["NORMAL"]).size(), count);
      EXPECT_TRUE(file.json["accessors"]
                      .at(primitive["attributes"]["POSITION"].get<std::size_t>())
                      .contains("min"));
      EXPECT_LT(primitive["material"].get<std::size_t>(), file.json["materials"].size());
    }
  }
  for (const Json& animation : listed("animations")) {
    EXPECT_FALSE(animation["channels"].empty());
    for (const Json& sampler : animation["samplers"].elements()) {
      use(sampler["input"]);
      use(sampler["output"]);
      const auto times = vectors_of(file, sampler["input"]);
      EXPECT_EQ(vectors_of(file, sampler["output"]).size(), times.size());
      EXPECT_GE(times.front()[0], 0);
      EXPECT_TRUE(file.json["accessors"].at(sampler["input"].get<std::size_t>()).contains("max"));
      for (std::size_t i = 1; i < times.size(); ++i)
        EXPECT_LT(times[i - 1][0], times[i][0]);
    }
  }
  for (std::size_t i = 0; i < uses.size(); ++i) {
    EXPECT_GT(uses[i], 0) << "accessor " << i;
    const Json& accessor = file.json["accessors"][i];
    const auto vectors = vectors_of(file, i);
    std::vector<double> low = vectors.front();
    std::vector<double> high = low;
    for (const auto& vector : vectors) {
      for (std::size_t k = 0; k < vector.size(); ++k) {
        EXPECT_TRUE(std::isfinite(vector[k]));
        low[k] = std::min(low[k], vector[k]);
        high[k] = std::max(high[k], vector[k]);
      }
    }
    if (accessor.contains("min")) {
      EXPECT_EQ(accessor["min"].get<std::vector<double>>(), low);
      EXPECT_EQ(accessor["max"].get<std::vector<double>>(), high);
    }
  }
}

inline std::size_t node_named(const File& file, const std::string& name) {
  const Json::Array& nodes = file.json["nodes"].elements();
  const auto found =
      std::ranges::find_if(nodes, [&](const Json& node) { return node["name"] == name; });
  EXPECT_NE(found, nodes.end()) << name;
  return static_cast<std::size_t>(found - nodes.begin());
}

inline bool has_node(const File& file, const std::string& name) {
  return std::ranges::any_of(file.json["nodes"].elements(),
                             [&](const Json& node) { return node["name"] == name; });
}

struct Track {
  std::vector<double> times_s{};
  std::vector<std::vector<double>> values{};
  std::string interpolation{};
};

/// Returns an empty track if the clip has no channel of `node` and `path`.
inline Track track_of(const File& file, std::size_t clip, std::size_t node,
                      const std::string& path) {
  const Json& animation = file.json["animations"].at(clip);
  for (const Json& channel : animation["channels"].elements()) {
    if (channel["target"]["node"] != node || channel["target"]["path"] != path) continue;
    const Json& sampler = animation["samplers"].at(channel["sampler"].get<std::size_t>());
    Track track{.values = vectors_of(file, sampler["output"]),
                .interpolation = sampler["interpolation"].text()};
    for (const auto& time : vectors_of(file, sampler["input"]))
      track.times_s.push_back(time[0]);
    return track;
  }
  return {};
}

enum class Turning { slerp, normalised };

/// Returns the value that a player shows at `t_s`. Quaternions are interpolated the shortest way.
inline std::vector<double> played(const Track& track, double t_s,
                                  Turning turning = Turning::slerp) {
  const auto next = std::ranges::upper_bound(track.times_s, t_s);
  if (next == track.times_s.begin()) return track.values.front();
  if (next == track.times_s.end()) return track.values.back();
  const auto i = static_cast<std::size_t>(next - track.times_s.begin());
  const std::vector<double>& a = track.values[i - 1];
  std::vector<double> b = track.values[i];
  if (track.interpolation == "STEP") return a;
  const double share = (t_s - track.times_s[i - 1]) / (track.times_s[i] - track.times_s[i - 1]);
  double weight_a = 1 - share;
  double weight_b = share;
  if (a.size() == 4) {
    double along = 0;
    for (std::size_t k = 0; k < 4; ++k)
      along += a[k] * b[k];
    if (along < 0) {
      for (double& number : b)
        number = -number;
      along = -along;
    }
    const double angle = std::acos(std::min(1.0, along));
    if (turning == Turning::slerp && angle > 1e-6) {
      weight_a = std::sin((1 - share) * angle) / std::sin(angle);
      weight_b = std::sin(share * angle) / std::sin(angle);
    }
  }
  std::vector<double> between(a.size());
  for (std::size_t k = 0; k < a.size(); ++k)
    between[k] = weight_a * a[k] + weight_b * b[k];
  return between;
}

// Converts from glTF's axes (y up, z towards the viewer) to the scene's axes.
inline math::Vec3 z_up(const std::vector<double>& place) {
  return {place[0], -place[2], place[1]};
}
inline math::Quat z_up_turn(const std::vector<double>& turn) {
  return math::normalized(math::Quat(turn[3], turn[0], -turn[2], turn[1]));
}

inline double apart_rad(const math::Quat& a, const math::Quat& b) {
  const math::Quat turn = math::composed(a, math::inverse(b));
  return 2 * std::atan2(math::norm(math::Vec3(turn.x(), turn.y(), turn.z())), std::fabs(turn.w()));
}

}  // namespace sleight::gltf::testing
