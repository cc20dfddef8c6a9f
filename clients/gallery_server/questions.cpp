#include "clients/gallery_server/questions.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "clients/browse/groups.h"
#include "clients/browse/query.h"
#include "clients/gallery_server/refused.h"
#include "common/base/cores.h"

namespace sleight::gallery {
namespace {

using Json = json::Value;
using Question = json::Value;

constexpr unsigned k_other_generation = 409;
constexpr std::size_t k_alike_to_max = 100;

[[noreturn]] void refuse(const std::string& words) {
  throw Refused(k_bad_request, words, "Reload the page.");
}

const Question& field(const Question& ask, const char* name) {
  if (!ask.is_object()) refuse("The request is not a JSON object.");
  const auto* found = ask.find(name);
  if (!found) refuse(fmt::format("The request has no \"{}\".", name));
  return *found;
}

std::uint64_t whole(const Question& ask, const char* name) {
  const Question& value = field(ask, name);
  if (!value.is_whole()) refuse(fmt::format("\"{}\" is not an integer.", name));
  return value.get<std::uint64_t>();
}

std::uint64_t archive_of(const Gallery& gallery, const Question& ask) {
  const std::uint64_t id = whole(ask, "id");
  if (id >= gallery.archives())
    throw Refused(k_not_found, "This archive doesn't exist.", "Reload the page.");
  return id;
}

/// Returns the snapshot. Throws Refused if the request is for another generation.
std::shared_ptr<const Snapshot> asked_for(const Gallery& gallery, const Question& ask,
                                          std::shared_ptr<const Snapshot> snapshot) {
  if (!snapshot) refuse_unread(gallery, archive_of(gallery, ask));
  if (snapshot->generation() != whole(ask, "generation")) {
    throw Refused(k_other_generation, "The archive has changed and was read again.",
                  "Request its table again.");
  }
  return snapshot;
}

/// Returns the requested snapshot, which may be an outline.
std::shared_ptr<const Snapshot> snapshot_of(const Gallery& gallery, const Question& ask) {
  return asked_for(gallery, ask, gallery.snapshot(archive_of(gallery, ask)));
}

/// A snapshot with motions.
std::shared_ptr<const Snapshot> whole_of(const Gallery& gallery, const Question& ask) {
  return asked_for(gallery, ask, gallery.whole_snapshot(archive_of(gallery, ask)));
}

std::vector<std::size_t> entries_in(const Question& list, const Snapshot& snapshot) {
  const std::size_t count = snapshot.index().entries.size();
  if (!list.is_array() || list.size() > count) refuse("The animations are not a list.");
  std::vector<std::size_t> entries;
  std::vector<bool> is_in(count);
  for (const Question& one : list.elements()) {
    if (!one.is_whole() || one.get<std::uint64_t>() >= count)
      refuse("An animation's entry is invalid.");
    const auto entry = one.get<std::size_t>();
    if (!is_in[entry]) entries.push_back(entry);
    is_in[entry] = true;
  }
  return entries;
}

/// Returns the request's entries, or all entries if the request has none.
std::vector<std::size_t> meant(const Question& ask, const Snapshot& snapshot) {
  const auto* list = ask.find("entries");
  if (list && !list->is_null()) return entries_in(*list, snapshot);
  std::vector<std::size_t> all(snapshot.index().entries.size());
  std::iota(all.begin(), all.end(), std::size_t{0});
  return all;
}

/// Converts a byte offset in UTF-8 text to a character number, counted from 1.
std::size_t character_of(std::string_view text, std::size_t byte) {
  return 1 + static_cast<std::size_t>(std::ranges::count_if(text.substr(0, byte), [](char c) {
           constexpr unsigned k_two_bits = 0xC0;
           constexpr unsigned k_follows = 0x80;
           return (static_cast<unsigned char>(c) & k_two_bits) != k_follows;
         }));
}

/// Skips finds, because shares count only animations of chains.
std::vector<Share> shares(const Snapshot& snapshot, const browse::Groups& groups,
                          const std::vector<std::size_t>& entries) {
  const auto& all = snapshot.index().entries;
  std::vector<std::optional<std::size_t>> group_of_entry(all.size());
  for (std::size_t group = 0; group < groups.groups.size(); ++group) {
    for (const std::size_t member : groups.groups[group].members)
      group_of_entry[entries[member]] = group;
  }
  std::vector<std::optional<std::size_t>> group_of;
  for (std::size_t entry = 0; entry < all.size(); ++entry)
    if (!all[entry].name.is_find) group_of.push_back(group_of_entry[entry]);
  return shares_of(snapshot.facts().by_lineage, group_of, groups.groups.size());
}

bool are_all(const Snapshot& snapshot, const std::vector<std::size_t>& entries) {
  return entries.size() == snapshot.index().entries.size() && std::ranges::is_sorted(entries);
}

/// Groups of all entries use a set that the snapshot prepares only once.
browse::Groups groups_among(const Snapshot& snapshot, const std::vector<std::size_t>& entries,
                            std::size_t groups, browse::Grouping by) {
  const auto& all = snapshot.index().entries;
  if (are_all(snapshot, entries)) return snapshot.alike().groups(groups, by);
  std::vector<const browse::Entry*> of;
  for (const std::size_t entry : entries)
    of.push_back(&all[entry]);
  return browse::groups_of(of, snapshot.index().scene,
                           {.groups = groups, .by = by, .threads = base::cores_here()});
}

std::string why_no_shares(const Snapshot& snapshot) {
  const Facts& facts = snapshot.facts();
  if (facts.summary.chains * facts.summary.scans == 0)
    return "A search found these animations; their probability in the model is unknown.";
  if (!facts.in_proportion) return "The draws are not in the model's proportions.";
  if (snapshot.is_beginning()) return "Not all animations have been read yet.";
  if (!facts.satisfied) return "There are too many draws to count.";
  return "No draws can be counted.";
}

}  // namespace

Json found(const Gallery& gallery, const Question& ask) {
  const Question& query = field(ask, "query");
  const Question& archives = field(ask, "archives");
  if (!query.is_string()) refuse("The query is not a string.");
  if (!archives.is_array()) refuse("The archives are not a list.");
  const auto& text = query.text();
  const bool is_all = text.find_first_not_of(" \t\r\n") == std::string::npos;
  Json answer{{"found", Json::array()}, {"errors", Json::array()}};
  for (const Question& one : archives.elements()) {
    const auto snapshot = is_all ? snapshot_of(gallery, one) : whole_of(gallery, one);
    const browse::Index& index = snapshot->index();
    Json entries = Json::array();
    if (is_all) {
      for (std::size_t entry = 0; entry < index.entries.size(); ++entry)
        entries.push_back(entry);
    } else {
      const auto condition = browse::parse_query(text, index.scene, index.numbers);
      if (!condition) {
        answer["errors"].push_back({{"id", one["id"]},
                                    {"column", character_of(text, condition.error().column)},
                                    {"message", condition.error().message}});
        continue;
      }
      for (const std::size_t entry : browse::find(condition.value(), index))
        entries.push_back(entry);
    }
    answer["found"].push_back({{"id", one["id"]}, {"entries", std::move(entries)}});
  }
  return answer;
}

Json grouped(const Gallery& gallery, const Question& ask) {
  auto snapshot = snapshot_of(gallery, ask);
  const std::vector<std::size_t> entries = meant(ask, *snapshot);
  const std::uint64_t groups = whole(ask, "groups");
  if (groups < 1 || groups > browse::k_full_matrix_max)
    refuse(fmt::format("The number of groups must be 1 to {}.", browse::k_full_matrix_max));
  const Question& by = field(ask, "by");
  if (by != "medoids" && by != "hierarchy") refuse("\"by\" must be \"medoids\" or \"hierarchy\".");
  Json answer{{"approximate", false}, {"groups", Json::array()}, {"share_words", ""}};
  if (entries.empty()) return answer;

  const auto grouping = by == "hierarchy" ? browse::Grouping::hierarchy : browse::Grouping::medoids;
  const bool are_first = groups == browse::k_first_groups && grouping == browse::k_first_grouping &&
                         are_all(*snapshot, entries);
  if (!are_first) snapshot = whole_of(gallery, ask);
  const browse::Groups found =
      are_first ? snapshot->first_groups() : groups_among(*snapshot, entries, groups, grouping);
  const std::vector<Share> share = shares(*snapshot, found, entries);
  answer["approximate"] = found.is_approximate;
  if (share.empty()) answer["share_words"] = why_no_shares(*snapshot);
  for (std::size_t i = 0; i < found.groups.size(); ++i) {
    const browse::AlikeGroup& group = found.groups[i];
    Json members = Json::array();
    for (const std::size_t member : group.members)
      members.push_back(entries[member]);
    Json said = nullptr;
    if (!share.empty()) {
      said = {{"value", share[i].value},
              {"error", std::isnan(share[i].error) ? Json(nullptr) : Json(share[i].error)}};
    }
    answer["groups"].push_back({{"representative", entries[group.representative]},
                                {"members", std::move(members)},
                                {"mean_m", group.mean_m},
                                {"greatest_m", group.greatest_m},
                                {"share", std::move(said)}});
  }
  return answer;
}

Json alike(const Gallery& gallery, const Question& ask) {
  const auto snapshot = whole_of(gallery, ask);
  const std::vector<std::size_t> to = entries_in(field(ask, "to"), *snapshot);
  if (to.empty() || to.size() > k_alike_to_max)
    refuse(fmt::format("Sorting by likeness needs 1 to {} animations.", k_alike_to_max));
  const std::vector<std::size_t> entries = meant(ask, *snapshot);
  const browse::AlikeSet& set = snapshot->alike();
  std::vector<std::pair<double, std::size_t>> nearest;
  for (const std::size_t entry : entries) {
    double least = std::numeric_limits<double>::infinity();
    for (const std::size_t one : to)
      least = std::min(least, set.between(one, entry).value_m());
    nearest.emplace_back(least, entry);
  }
  std::ranges::sort(nearest);
  Json answer{{"entries", Json::array()}, {"distance_m", Json::array()}};
  for (const auto& [distance, entry] : nearest) {
    answer["entries"].push_back(entry);
    answer["distance_m"].push_back(distance);
  }
  return answer;
}

}  // namespace sleight::gallery
