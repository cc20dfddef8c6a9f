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

struct Peg {
  double x_m = 0.5;
  std::optional<double> y_m{};
  friend bool operator==(const Peg&, const Peg&) = default;
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
  friend bool operator==(const Parameters&, const Parameters&) = default;
};

inline constexpr std::array k_surfaces{Named<Surface>{"felt", Surface::felt},
                                       Named<Surface>{"wood", Surface::wood}};

inline void bind(WorldSections& sections, Parameters& p) {
  auto& [world, constraint, sampler] = sections;
  world.number("height_m", p.height_m,
               {.minimum = 0, .above_minimum = true, .maximum = 100, .unit = "m"});
  world.angle_deg("tilt_deg", p.tilt_rad, {.minimum = -90, .maximum = 90});
  world.integer("balls", p.balls, {.minimum = 1, .maximum = 9, .help = "how many"});
  world.boolean("spinning", p.spinning, "whether they spin");
  world.choice("surface", p.surface, std::span<const Named<Surface>>(k_surfaces),
               "what they roll on");
  world.tables<Peg>("peg", p.pegs, {.count_max = 3, .help = "what they hit"},
                    [](Binder& table, Peg& peg) {
                      table.number("x_m", peg.x_m, {.minimum = 0, .maximum = 9});
                      table.optional_number("y_m", peg.y_m, {.maximum = 9});
                      if (peg.y_m == peg.x_m) table.error("y_m", "is x_m");
                    });
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
  staged.acts_in_stages = true;
  return staged;
}

/// Returns the toy world. By default, finds are relaxed with three scans and step 0.5.
inline WorldBinding relaxing_binding() {
  return bind_world<Parameters>(
      "staged", "a world for tests", &bind,
      [](WorldSections& sections, SamplerParameters& sampler, const StopRule& stop, Parameters& p) {
        if (!stop.takes) return;
        Settled settled(sections.sampler);
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
