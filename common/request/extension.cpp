#include "common/request/extension.h"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>
#include <utility>
#include <vector>

#include "common/request/text.h"

namespace sleight::request {
namespace {

template <typename Number>
void complain_if_no_longer(std::string_view rule, const std::optional<Number>& asked,
                           const std::optional<Number>& before, bool less_is_longer,
                           std::string& complaint) {
  if (!asked || !before || !complaint.empty()) return;
  if (less_is_longer ? *asked < *before : *asked > *before) return;
  complaint = fmt::format("[stop] already has {} = {}; set a {} number", rule, *before,
                          less_is_longer ? "smaller" : "larger");
}

std::vector<std::pair<std::string, std::string>> rules_of(const DirectionRequest& request,
                                                          const Extension& extension) {
  const bool searches = request.sampler.method == Method::search;
  std::vector<std::pair<std::string, std::string>> rules;
  const auto add = [&](std::string_view rule, std::string value) {
    rules.emplace_back(std::string(rule), std::move(value));
  };
  if (extension.scans) add("scans", fmt::format("{}", *extension.scans));
  if (extension.rounds) add("rounds", fmt::format("{}", *extension.rounds));
  if (extension.solutions && !searches)
    add("independent_solutions", fmt::format("{}", *extension.solutions));
  if (extension.odds) add("odds", toml_number(*extension.odds));
  if (request.stop.takes)
    add("takes", fmt::format("{}", extension.solutions.value_or(*request.stop.takes)));
  const std::optional<std::uint32_t> found =
      request.stop.found && extension.solutions ? extension.solutions : request.stop.found;
  if (found) add("found", fmt::format("{}", *found));
  return rules;
}

}  // namespace

base::Result<std::string, NotLonger> extended_text(const DirectionRequest& request,
                                                   const Extension& extension) {
  if (extension == Extension{}) return NotLonger{"no stop rule is given"};
  const StopRule& before = request.stop;
  const bool searches = request.sampler.method == Method::search;
  std::string complaint;
  complain_if_no_longer("scans", extension.scans, before.scans, false, complaint);
  complain_if_no_longer("rounds", extension.rounds, before.rounds, false, complaint);
  complain_if_no_longer(before.takes ? "takes"
                        : searches   ? "found"
                                     : "independent_solutions",
                        extension.solutions,
                        before.takes ? before.takes
                        : searches   ? before.found
                                     : before.independent_solutions,
                        false, complaint);
  complain_if_no_longer("odds", extension.odds, before.odds, true, complaint);
  if (!complaint.empty()) return NotLonger{std::move(complaint)};

  DirectionRequest longer = request;
  const auto stop = std::find_if(longer.sections.begin(), longer.sections.end(),
                                 [](const NormalisedSection& s) { return s.name == "stop"; });
  CHECK(stop != longer.sections.end());
  stop->keys = rules_of(request, extension);
  return normalised_text(longer);
}

}  // namespace sleight::request
