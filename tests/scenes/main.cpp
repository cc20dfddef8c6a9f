// `sleight-scenes` writes a page. For each scene in shared/, the page has a strip of pictures.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "common/base/error.h"
#include "common/base/version.h"
#include "tests/scenes/strip.h"

namespace {

namespace scenes = sleight::physics::scenes;
using sleight::scene_pictures::Strip;
using sleight::scene_pictures::strip_of;

struct Arguments {
  std::string out = "scenes";
  std::vector<std::string> only;
  std::uint32_t bodies = 0;
  std::uint64_t seed = 1;
  bool quick = false;
};

/// Writes a temporary file next to `path`, then renames it to `path`.
void save(const std::filesystem::path& path, const std::string& bytes) {
  const std::filesystem::path beside = path.string() + ".part";
  std::ofstream file(beside, std::ios::binary);
  file << bytes;
  file.close();
  if (!file)
    throw sleight::base::Error(sleight::base::ExitCode::environment,
                               fmt::format("can't write {}", path.string()));
  std::filesystem::rename(beside, path);
}

std::string figure_of(const scenes::SceneEntry& entry, const std::string& words) {
  return fmt::format(
      "<figure id=\"{0}\">\n<img src=\"{0}.svg\" alt=\"{1}\">\n<figcaption><b>{0}</b>: {1}; {2}"
      "</figcaption>\n</figure>\n",
      entry.name, entry.what, words);
}

void draw(const Arguments& arguments) {
  std::filesystem::create_directories(arguments.out);
  std::string figures;
  for (const scenes::SceneEntry& entry : scenes::all()) {
    if (!arguments.only.empty() &&
        std::ranges::find(arguments.only, entry.name) == arguments.only.end())
      continue;
    std::uint32_t bodies = arguments.bodies > 0 ? arguments.bodies : entry.bodies_default;
    bodies = std::min(bodies, arguments.quick ? 100U : entry.bodies_max);
    scenes::Setting setting = entry.make(bodies, arguments.seed);
    if (arguments.quick) setting.duration_s = std::min(setting.duration_s, 0.2);
    const Strip strip = strip_of(setting, fmt::format("{}: {}", entry.name, entry.what));
    if (!strip.error.empty())
      throw sleight::base::Error(
          strip.refused ? sleight::base::ExitCode::usage : sleight::base::ExitCode::bug,
          fmt::format("{}: {}", entry.name, strip.error));
    const std::string words =
        fmt::format("{} bodies, {:.3g} s, seed {}", setting.scene.bodies.size(), setting.duration_s,
                    arguments.seed);
    save(std::filesystem::path(arguments.out) / fmt::format("{}.svg", entry.name), strip.svg);
    figures += figure_of(entry, words);
    fmt::print("{}: {}\n", entry.name, words);
    std::fflush(stdout);
  }
  const std::filesystem::path page = std::filesystem::path(arguments.out) / "scenes.html";
  save(page,
       fmt::format("<!DOCTYPE html>\n<html lang=\"en\">\n<meta charset=\"utf-8\">\n"
                   "<meta name=\"viewport\" content=\"width=device-width\">\n"
                   "<title>Scenes of Sleight's simulator</title>\n<style>\n"
                   "body {{ font-family: sans-serif; max-width: 70rem; margin: 1rem auto; }}\n"
                   "img {{ width: 100%; }}\nfigure {{ margin: 1.5rem 0; }}\n</style>\n"
                   "<h1>Scenes of the simulator</h1>\n"
                   "<p>Five moments of each, from its start to its end, as sleight-scenes "
                   "{} draws them.</p>\n{}</html>\n",
                   sleight::base::version(), figures));
  fmt::print("{}\n", page.string());
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{
      "Simulates the scenes that tests and benchmarks share, and draws a page of them: a strip of "
      "five\nmoments for each."};
  app.name("sleight-scenes");
  Arguments arguments;
  std::vector<std::string> names;
  for (const scenes::SceneEntry& entry : scenes::all())
    names.emplace_back(entry.name);
  app.add_option("--out", arguments.out, "Folder of scenes.html and the pictures")
      ->capture_default_str();
  app.add_option("--only", arguments.only, "Scenes; all if not given")->check(CLI::IsMember(names));
  app.add_option("--bodies", arguments.bodies,
                 "How many, as far as a scene can; each scene's own number if not given")
      ->check(CLI::Range(1U, scenes::SceneEntry{}.bodies_max));
  app.add_option("--seed", arguments.seed, "Of all scenes")->capture_default_str();
  app.set_version_flag("--version", "sleight-scenes " + std::string(sleight::base::version()));
  app.add_flag("--quick", arguments.quick, "Few bodies, short: that it works");
  app.footer(
      "Examples, from the project's root:\n"
      "  build/release/bin/sleight-scenes --out /tmp/scenes\n"
      "  build/release/bin/sleight-scenes --only bowling --seed 3");
  CLI11_PARSE(app, argc, argv);
  try {
    draw(arguments);
  } catch (const sleight::base::Error& error) {
    fmt::print(stderr, "sleight-scenes: {}\n", error.what());
    return static_cast<int>(error.exit_code());
  } catch (const std::exception& error) {
    fmt::print(stderr, "sleight-scenes: {}\n", error.what());
    return static_cast<int>(sleight::base::ExitCode::bug);
  }
  return 0;
}
