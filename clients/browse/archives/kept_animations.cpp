#include "clients/browse/archives/kept_animations.h"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>
#include <set>
#include <utility>

#include "clients/analysis/archive_rows.h"
#include "common/archive/format.h"
#include "common/archive/summary.h"
#include "common/base/error.h"

namespace sleight::browse {
namespace {

/// Throws an error with the reason why there is nothing to draw, and what to do.
[[noreturn]] void refuse_empty(const archive::Source& source, std::optional<std::uint64_t> chain) {
  const archive::Summary summary = archive::summary_of(source);
  const std::string whose = chain ? fmt::format(" of chain {}", *chain) : "";
  const char* why = summary.keep_max <= 0 ? "the request stores no animations (keep_max = 0)"
                    : summary.keep_per_lineage <= 0
                        ? "the request stores no animations (keep_per_lineage = 0)"
                    : chain ? "try another chain or run more scans"
                            : "run more scans";
  throw base::Error(base::ExitCode::usage, fmt::format("{}: no satisfying animation{} to draw; {}",
                                                       source.name(), whose, why));
}

}  // namespace

std::string_view drawn_group(const archive::Source& source) {
  const archive::Summary summary = archive::summary_of(source);
  return summary.animations == 0 && summary.finds.animations > 0 ? archive::k_finds
                                                                 : archive::k_animations;
}

std::string where_found(const archive::Source& source, std::size_t animation,
                        const std::function<std::string(double)>& step_of_draw) {
  const std::string_view group = drawn_group(source);
  const auto number = [&](std::string_view dataset) {
    return analysis::read_rows(source, group, dataset, 1, {.first = animation, .count = 1}).front();
  };
  if (group == archive::k_finds) {
    const bool is_take = archive::summary_of(source).finds.relax_scans > 0;
    return fmt::format("{} {} of start {}, not in proportion", is_take ? "take" : "find", animation,
                       number("start"));
  }
  return fmt::format("chain {}, {}", number("chain"), step_of_draw(number("draw")));
}

std::vector<double> of_animations(const archive::Source& source, std::string_view dataset) {
  const archive::Summary summary = archive::summary_of(source);
  const std::string_view group = drawn_group(source);
  return analysis::read_rows(
      source, group, dataset, 1,
      {.count = group == archive::k_finds ? summary.finds.animations : summary.animations});
}

void refuse_animation(const archive::Source& source, std::string_view name,
                      std::string_view reason) {
  throw base::Error(base::ExitCode::bad_archive,
                    fmt::format("{}: animation {} {}", source.name(), name, reason));
}

void refuse_animation(const archive::Source& source, std::size_t animation,
                      std::string_view reason) {
  refuse_animation(source, fmt::format("{}", animation), reason);
}

scene::Scene required_scene(const archive::Source& source) {
  auto scene = archive::scene_of(source);
  if (scene) return std::move(scene).value();
  throw base::Error(base::ExitCode::bad_archive,
                    fmt::format("{}: {}", source.name(), scene.error()));
}

KeptAnimation kept_animation(const archive::Source& source, const archive::KeptMotions& motions,
                             std::uint64_t row, const scene::Scene& scene, std::string_view name) {
  auto motion = motions.animation(row, scene);
  if (!motion) refuse_animation(source, name, "is invalid: " + motion.error());
  auto own = motions.variation(row, scene);
  if (!own) refuse_animation(source, name, own.error());
  return {.motion = std::move(motion).value(),
          .own = std::move(own).value(),
          .offsets_m = motions.offsets_m(row, scene)};
}

std::vector<std::size_t> choose_animations(const archive::Source& source,
                                           std::optional<std::uint64_t> only, std::size_t count) {
  if (drawn_group(source) == archive::k_finds) {
    if (only) {
      throw base::Error(
          base::ExitCode::usage,
          fmt::format("{}: the animations come from a search, which has no chains", source.name()));
    }
    std::vector<std::size_t> all(of_animations(source, "start").size());
    std::iota(all.begin(), all.end(), std::size_t{0});
    all.resize(std::min(all.size(), count));
    return all;
  }
  if (only) analysis::check_chain(source, *only);
  const std::vector<double> chain = of_animations(source, "chain");
  const std::vector<double> lineage = of_animations(source, "lineage");
  std::set<std::pair<double, double>> seen;
  std::vector<std::size_t> first;
  std::vector<std::size_t> others;
  for (std::size_t i = 0; i < chain.size(); ++i) {
    if (only && chain[i] != static_cast<double>(*only)) continue;
    (seen.emplace(chain[i], lineage[i]).second ? first : others).push_back(i);
  }
  first.insert(first.end(), others.begin(), others.end());
  first.resize(std::min(first.size(), count));
  if (first.empty()) refuse_empty(source, only);
  return first;
}

}  // namespace sleight::browse
