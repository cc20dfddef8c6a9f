// A toy world for request tests. The world has every kind of key, and no simulation.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "common/request/direction_request.h"
#include "common/request/settled.h"

namespace sleight::request::toy {

enum class Surface { felt, wood };

struct Ring {
  std::array<double, 2> at_m{0.5, -1};
  Surface surface = Surface::felt;
  friend bool operator==(const Ring&, const Ring&) = default;
};

struct Peg {
  double x_m = 0.5;
  std::optional<double> y_m{};
  std::vector<Ring> rings{};
  friend bool operator==(const Peg&, const Peg&) = default;
};

struct Noise {
  double sd = 0.1;
  friend bool operator==(const Noise&, const Noise&) = default;
};

/// Has every kind of array.
struct Wind {
  double scale = 1;
  std::string from = "N";
  std::optional<std::string> name{};
  std::optional<std::array<double, 3>> mps{};
  std::vector<double> gusts{};
  std::vector<std::array<double, 2>> path{};
  std::vector<std::array<std::uint8_t, 3>> triangles{};
  std::vector<std::string> places{};
  std::optional<Noise> noise{};
  friend bool operator==(const Wind&, const Wind&) = default;
};

struct Parameters {
  double height_m = 2;
  double tilt_rad = 0.17453292519943295;  // 10 degrees
  std::uint32_t balls = 3;
  bool spinning = true;
  std::string word = "HI";
  Surface surface = Surface::felt;
  double lambda = 0.25;
  double step = 0.1;
  std::vector<Peg> pegs{};
  std::optional<Wind> wind{};
  friend bool operator==(const Parameters&, const Parameters&) = default;
};

inline constexpr std::array k_surfaces{Named<Surface>{"felt", Surface::felt},
                                       Named<Surface>{"wood", Surface::wood}};

inline void bind_wind(Binder& table, Wind& wind) {
  table.required_number("scale", wind.scale, {.minimum = 0});
  table.required_text("from", wind.from, {.characters_max = 2});
  table.optional_text("name", wind.name, {.characters_max = 4});
  std::array<double, 3> mps{};
  if (table.optional_numbers("mps", mps, {.minimum = -9, .maximum = 9, .unit = "m/s"}))
    wind.mps = mps;
  table.numbers("gusts", wind.gusts, {.count_max = 3}, {});
  table.rows("path", wind.path, {.count_min = 2, .count_max = 4}, {.minimum = 0});
  table.rows("triangles", wind.triangles, {.count_max = 3}, {.minimum = 0, .maximum = 9});
  table.texts("places", wind.places, {.count_min = 2, .count_max = 2, .required = true},
              {.characters_max = 4});
  Noise noise;
  const bool is_noisy = table.table("noise", noise, "how it varies", [](Binder& inner, Noise& n) {
    inner.number("sd", n.sd, {.minimum = 0});
  });
  if (is_noisy) wind.noise = noise;
}

inline void bind(WorldSections& sections, Parameters& p) {
  auto& [world, constraint, sampler] = sections;
  world.number("height_m", p.height_m,
               {.minimum = 0, .above_minimum = true, .maximum = 100, .unit = "m"});
  world.angle_deg("tilt_deg", p.tilt_rad, {.minimum = -90, .maximum = 90});
  world.integer("balls", p.balls, {.minimum = 1, .maximum = 9, .help = "how many"});
  world.boolean("spinning", p.spinning, "whether they spin");
  world.choice("surface", p.surface, std::span<const Named<Surface>>(k_surfaces),
               "what they roll on");
  world.tables<Peg>(
      "peg", p.pegs, {.count_max = 3, .help = "what they hit"}, [](Binder& table, Peg& peg) {
        table.number("x_m", peg.x_m, {.minimum = 0, .maximum = 9});
        table.optional_number("y_m", peg.y_m, {.maximum = 9});
        table.tables("ring", peg.rings, {.count_max = 2}, [](Binder& inner, Ring& ring) {
          inner.numbers("at_m", ring.at_m, {.minimum = -9, .maximum = 9});
          inner.choice("surface", ring.surface, std::span<const Named<Surface>>(k_surfaces), "");
        });
        if (peg.y_m == peg.x_m) table.error("y_m", "is x_m");
      });
  Wind wind;
  if (world.table("wind", wind, "what blows", &bind_wind)) p.wind = wind;
  constraint.text("word", p.word, {.characters_max = 4, .help = "what they spell"});
  constraint.number("lambda", p.lambda, {});
  sampler.number("step", p.step, {.minimum = 0, .maximum = 1, .below_maximum = true});
  if (p.word.empty() && constraint.valid("word")) constraint.error("word", "nothing to spell");
}

inline WorldBinding binding(std::string name = "toy") {
  return bind_world<Parameters>(std::move(name), "a world for tests", &bind);
}

inline WorldBinding staged_binding() {
  WorldBinding staged = binding("staged");
  staged.has_search = true;
  staged.has_islands = true;
  return staged;
}

/// Returns the toy world. By default, finds are relaxed with three scans and step 0.5.
inline WorldBinding relaxing_binding() {
  return bind_world<Parameters>(
      "staged", "a world for tests", &bind,
      [](WorldSections& sections, SamplerParameters& sampler, const StopRule& stop, Parameters& p) {
        if (!stop.takes) return;
        Settled settled(sections.sampler, sampler);
        settled.count("relax_scans", sampler.relax_scans, 3);
        settled.number("step", p.step, 0.5);
      });
}

inline std::vector<std::string> errors_of(std::string_view text) {
  const std::array worlds{binding(), binding("toy_2")};
  const auto request = read_request(text, "r.toml", worlds);
  std::vector<std::string> errors;
  if (!request) {
    for (const Diagnostic& diagnostic : request.error())
      errors.push_back(to_string(diagnostic));
  }
  return errors;
}

}  // namespace sleight::request::toy
