#include "clients/gallery_server/archive_answers.h"

#include <utility>

#include <fmt/format.h>

#include "clients/analysis/diagnosis_report.h"
#include "clients/gallery_server/meshes.h"
#include "clients/gallery_server/packed.h"
#include "clients/gallery_server/recording.h"
#include "clients/gallery_server/refused.h"
#include "clients/gallery_server/tables.h"

namespace sleight::gallery {
namespace {

using Json = json::Value;

std::size_t required_entry(const Snapshot& snapshot, std::string_view name) {
  const auto entry = snapshot.entry_of(name);
  if (!entry) throw Refused(k_not_found, "This animation doesn't exist.", "Reload the page.");
  return *entry;
}

}  // namespace

Json scene_json(const Snapshot& snapshot) {
  const browse::Index& index = snapshot.index();
  return {{"generation", snapshot.generation()},
          {"view_low_m", place_json(index.scene.low_m)},
          {"view_high_m", place_json(index.scene.high_m)},
          {"offsets", !index.scene.offset_variable.empty()},
          {"features", features_json(index.scene)},
          {"numbers", numbers_json(index)},
          {"prior_log_prior", snapshot.facts().prior_log_prior},
          {"request", snapshot.facts().summary.request_text}};
}

std::string looks(const Snapshot& snapshot) {
  const scene::Scene& scene = snapshot.index().scene;
  Packed packed;
  Json meshes = add_meshes(packed, "", scene, common_features(scene), {}, {});
  return packed.finish({{"generation", snapshot.generation()},
                        {"meshes", std::move(meshes)},
                        {"own", own_features(scene)}});
}

std::string table(const Snapshot& snapshot) {
  const browse::Index& index = snapshot.index();
  Packed packed;
  add_table(packed, index);
  Json names = Json::array();
  for (const browse::NumberName& number : index.numbers)
    names.push_back(number.name);
  return packed.finish({{"generation", snapshot.generation()},
                        {"entries", index.entries.size()},
                        {"numbers", std::move(names)}});
}

std::string one_animation(const Snapshot& snapshot, std::string_view name) {
  const std::size_t entry = required_entry(snapshot, name);
  Packed packed;
  Json head = add_animation(packed, "", std::string(name), snapshot.animation(entry),
                            snapshot.index().scene);
  return packed.finish(head);
}

std::string several_animations(const Snapshot& snapshot, std::span<const std::string> names) {
  if (names.empty() || names.size() > k_animations_at_once) {
    throw Refused(k_bad_request,
                  fmt::format("A request must name 1 to {} animations.", k_animations_at_once),
                  "Request fewer at once.");
  }
  Packed packed;
  Json heads = Json::array();
  for (std::size_t i = 0; i < names.size(); ++i) {
    const std::size_t entry = required_entry(snapshot, names[i]);
    heads.push_back(add_animation(packed, fmt::format("{}:", i), names[i],
                                  snapshot.animation(entry), snapshot.index().scene));
  }
  return packed.finish({{"generation", snapshot.generation()}, {"animations", std::move(heads)}});
}

Json diagnosis_json(const Snapshot& snapshot, const std::string& path,
                    const analysis::Rules& rules) {
  Json json;
  snapshot.read([&](const archive::Source& source) {
    json = analysis::as_json(path, analysis::diagnosis_of(source, rules));
  });
  return json;
}

}  // namespace sleight::gallery
