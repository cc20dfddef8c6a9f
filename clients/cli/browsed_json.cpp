#include "clients/cli/browsed_json.h"

#include <cmath>

namespace sleight::cli {

Json number_json(double number) {
  return std::isfinite(number) ? Json(number) : Json(nullptr);
}

Json archives_json(const browse::Browsed& browsed) {
  Json json{{"archives", Json::array()}, {"left_out", Json::array()}};
  for (const browse::BrowsedArchive& archive : browsed.archives) {
    json["archives"].push_back({{"path", archive.path},
                                {"run_id", archive.index.run_id},
                                {"world", archive.index.world},
                                {"animations", archive.index.entries.size() + archive.twice},
                                {"in_an_archive_before", archive.twice}});
  }
  for (const browse::LeftOut& left : browsed.left_out)
    json["left_out"].push_back({{"path", left.path}, {"reason", left.reason}});
  return json;
}

Json animation_json(const browse::Browsed& browsed, const browse::Picked& picked) {
  const browse::Entry& entry = *picked.entry;
  Json json{{"id", name_among(browsed, entry.name)},
            {"archive", picked.archive->path},
            {"run_id", entry.name.run},
            {"group", entry.name.is_find ? "finds" : "animations"},
            {"row", entry.row},
            {"in_proportion", entry.in_proportion}};
  Json numbers = Json::object();
  for (std::size_t i = 0; i < entry.numbers.size(); ++i)
    numbers[picked.archive->index.numbers[i].name] = number_json(entry.numbers[i]);
  json["numbers"] = std::move(numbers);
  return json;
}

Json names_json(const browse::BrowsedArchive& archive) {
  Json json{{"path", archive.path},
            {"bodies", Json::array()},
            {"things", Json::array()},
            {"numbers", Json::array()}};
  for (const scene::Feature& feature : archive.index.scene.features) {
    if (feature.kind == scene::FeatureKind::body) json["bodies"].push_back(feature.name);
    if (feature.kind == scene::FeatureKind::fixed) json["things"].push_back(feature.name);
  }
  for (const browse::NumberName& number : archive.index.numbers)
    json["numbers"].push_back({{"name", number.name}, {"unit", number.unit}});
  return json;
}

}  // namespace sleight::cli
