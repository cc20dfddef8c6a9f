#include "clients/gallery_server/summary_json.h"

#include <algorithm>
#include <cstdint>
#include <string>

#include <fmt/format.h>

#include "common/events/progress.h"

namespace sleight::gallery {
namespace {

using Json = json::Value;

std::string as_of(const archive::Summary& summary) {
  std::string words;
  if (summary.chains * summary.scans > 0) {
    words = summary.chains == 1 ? fmt::format("scan {}", events::grouped(summary.scans))
                                : fmt::format("scan {} of each of {} chains",
                                              events::grouped(summary.scans), summary.chains);
  }
  if (summary.finds.found > 0) {
    words +=
        fmt::format("{}{} {}", words.empty() ? "" : "; ", events::grouped(summary.finds.found),
                    summary.finds.relax_scans > 0 ? "relaxed from a search" : "found by search");
  }
  return words.empty() ? "no scan yet" : words;
}

}  // namespace

void add_facts(Json& json, const Snapshot& snapshot) {
  const Facts& facts = snapshot.facts();
  const archive::Summary& summary = facts.summary;
  const std::uint64_t finds = static_cast<std::uint64_t>(std::ranges::count_if(
      snapshot.index().entries, [](const browse::Entry& entry) { return entry.name.is_find; }));
  json["run"] = summary.run_id;
  json["generation"] = snapshot.generation();
  json["world"] = summary.world;
  json["kept"] = snapshot.index().entries.size() - finds;
  json["finds"] = finds;
  json["is_beginning"] = snapshot.is_beginning();
  json["keep_max"] = summary.keep_max;
  json["chains"] = summary.chains;
  json["scans"] = summary.scans;
  json["draws"] = summary.chains * summary.scans;
  json["as_of"] = as_of(summary);
  json["warning"] = summary.warning;
  json["method"] = facts.method;
  json["in_proportion"] = facts.in_proportion;
  json["satisfied"] =
      facts.satisfied ? Json{{"draws", *facts.satisfied}, {"of", summary.chains * summary.scans}}
                      : Json(nullptr);
}

void add_no_facts(Json& json) {
  for (const char* text : {"run", "world", "as_of", "warning", "method"})
    json[text] = "";
  for (const char* number : {"generation", "kept", "finds", "keep_max", "chains", "scans", "draws"})
    json[number] = 0;
  json["is_beginning"] = false;
  json["in_proportion"] = false;
  json["satisfied"] = nullptr;
}

}  // namespace sleight::gallery
