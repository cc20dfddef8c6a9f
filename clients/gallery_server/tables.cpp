#include "clients/gallery_server/tables.h"

#include <cstdint>
#include <vector>

#include <fmt/format.h>

#include "clients/gallery_server/meshes.h"

namespace sleight::gallery {
namespace {

using Json = json::Value;

}  // namespace

void add_table(Packed& to, const browse::Index& index) {
  std::vector<std::uint8_t> is_find;
  std::vector<std::uint8_t> in_proportion;
  std::vector<std::uint32_t> chain;
  std::vector<double> draw;
  std::vector<double> lineage;
  std::vector<double> end_s;
  for (const browse::Entry& entry : index.entries) {
    is_find.push_back(entry.name.is_find ? 1 : 0);
    in_proportion.push_back(entry.in_proportion ? 1 : 0);
    chain.push_back(static_cast<std::uint32_t>(entry.name.chain));
    draw.push_back(static_cast<double>(entry.name.draw));
    lineage.push_back(static_cast<double>(entry.lineage));
    end_s.push_back(entry.end_s);
  }
  to.add("is_find", is_find);
  to.add("chain", chain);
  to.add("draw", draw);
  to.add("in_proportion", in_proportion);
  to.add("end_s", end_s);
  to.add("lineage", lineage);
  for (std::size_t number = 0; number < index.numbers.size(); ++number) {
    std::vector<double> column;
    column.reserve(index.entries.size());
    for (const browse::Entry& entry : index.entries)
      column.push_back(entry.numbers[number]);
    to.add(fmt::format("number.{}", number), column);
  }
}

Json place_json(const math::Vec3& v) {
  return Json::array({v.x(), v.y(), v.z()});
}

Json numbers_json(const browse::Index& index) {
  Json numbers = Json::array();
  for (const browse::NumberName& number : index.numbers)
    numbers.push_back({{"name", number.name}, {"unit", number.unit}});
  return numbers;
}

Json features_json(const scene::Scene& scene) {
  Json features = Json::array();
  for (std::uint32_t i = 0; i < scene.features.size(); ++i) {
    const scene::Feature& feature = scene.features[i];
    const bool is_body = feature.kind == scene::FeatureKind::body;
    features.push_back({{"name", feature.name},
                        {"kind", scene::k_kind_names.at(static_cast<std::size_t>(feature.kind))},
                        {"twin_of", feature.twin_of},
                        {"body", feature.body},
                        {"radius_m", is_body ? radius_m(scene, i) : 0.0}});
  }
  return features;
}

}  // namespace sleight::gallery
