#include <fmt/format.h>

#include <algorithm>
#include <string_view>

#include "common/request/direction_request.h"

namespace sleight::request {
namespace {

std::string text_of(std::span<const NormalisedSection> sections) {
  std::string text;
  for (const NormalisedSection& section : sections) {
    if (!text.empty()) text += '\n';
    text += fmt::format("[{}]\n", section.name);
    for (const auto& [key, value] : section.keys)
      text += fmt::format("{} = {}\n", key, value);
  }
  return text;
}

NormalisedSection& section_of(DirectionRequest& request, std::string_view name) {
  const auto at = std::find_if(request.sections.begin(), request.sections.end(),
                               [&](const NormalisedSection& s) { return s.name == name; });
  CHECK(at != request.sections.end());
  return *at;
}

/// Returns whether this rule of [stop] depends on the results of islands.
bool hangs_on_islands(std::string_view rule) {
  return rule == "independent_solutions" || rule == "odds";
}

}  // namespace

std::string normalised_text(const DirectionRequest& request) {
  return text_of(request.sections);
}

std::string normalised_text_of(const DirectionRequest& request, const Cut& cut) {
  CHECK(cut.scans > 0 || cut.found > 0 || cut.relaxed > 0);
  CHECK_LE(cut.scans, k_scans_max);
  CHECK_LE(cut.found, k_found_max);
  DirectionRequest stopped = request;
  const bool is_search = request.sampler.method == Method::search;
  const bool has_takes = cut.relaxed > 0;
  if (cut.scans == 0 && !has_takes && (!is_search || request.sampler.relax_scans)) {
    stopped.stop.found = static_cast<std::uint32_t>(cut.found);
    stopped = search_of(std::move(stopped));
  }
  auto& rules = section_of(stopped, "stop").keys;
  const bool has_islands = makes_islands(request.sampler.method) && cut.scans > 0;
  std::erase_if(rules,
                [&](const auto& rule) { return !has_islands || !hangs_on_islands(rule.first); });
  if (cut.scans > 0) rules.emplace(rules.begin(), "scans", fmt::format("{}", cut.scans));
  if (has_takes) rules.emplace_back("takes", fmt::format("{}", cut.relaxed));
  if (cut.found > 0 && !has_takes) rules.emplace_back("found", fmt::format("{}", cut.found));
  for (auto& [key, value] : section_of(stopped, "output").keys)
    if (key == "prior_draws") value = fmt::format("{}", cut.prior_draws);
  return normalised_text(stopped);
}

std::string identity_text(const DirectionRequest& request) {
  std::vector<NormalisedSection> walked;
  for (const NormalisedSection& section : request.sections) {
    if (section.name != "stop" && section.name != "output") walked.push_back(section);
  }
  return text_of(walked);
}

DirectionRequest with_seed(DirectionRequest request, std::uint64_t seed) {
  CHECK_LE(seed, k_seed_max);
  request.sampler.seed = seed;
  for (auto& [key, value] : section_of(request, "sampler").keys) {
    if (key == "seed") value = fmt::format("{}", seed);
  }
  return request;
}

DirectionRequest search_of(DirectionRequest request) {
  CHECK(request.stop.found || request.stop.takes);
  const auto keep_only = [&](std::string_view section,
                             std::initializer_list<std::string_view> kept) {
    std::erase_if(section_of(request, section).keys, [&](const auto& key) {
      return std::find(kept.begin(), kept.end(), key.first) == kept.end();
    });
  };
  keep_only("sampler", {"method", "seed"});
  keep_only("stop", {"found"});
  keep_only("output", {"keep_max", "prior_draws"});
  for (auto& [key, value] : section_of(request, "sampler").keys)
    if (key == "method") value = "\"search\"";
  const std::uint64_t seed = request.sampler.seed;
  request.sampler = {.method = Method::search, .chains = 0, .seed = seed};
  const auto found = request.stop.found ? request.stop.found : request.stop.takes;
  request.stop = {.scans = {}, .rounds = {}, .independent_solutions = {}, .found = found};
  request.output = {.keep_max = request.output.keep_max, .prior_draws = request.output.prior_draws};
  return request;
}

}  // namespace sleight::request
