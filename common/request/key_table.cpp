#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "common/request/common_sections.h"
#include "common/request/direction_request.h"

namespace sleight::request {
namespace {

using Row = std::array<std::string, 5>;

Row row_of(const KeySpec& spec) {
  const std::string fallback = spec.presence == Presence::required   ? "required"
                               : spec.presence == Presence::optional ? "none"
                                                                     : spec.fallback;
  return {spec.key, spec.unit.empty() ? "-" : spec.unit, spec.range, fallback, spec.help};
}

/// Columns as wide as their widest entry, two spaces apart; the last one is not padded.
std::string aligned(const std::vector<Row>& rows, const Row& widest) {
  std::string text;
  for (const Row& row : rows) {
    text += ' ';
    for (std::size_t i = 0; i + 1 < row.size(); ++i) {
      text += fmt::format(" {:<{}} ", row[i], widest[i].size());
    }
    text += ' ' + row.back() + '\n';
  }
  return text;
}

}  // namespace

std::vector<SectionKeys> request_keys(const WorldBinding& world) {
  // A request of this world alone, with only its name in it, has every key at its default.
  Document document;
  document.sections.push_back({"world", {}, {{"name", {}, {.held = world.name, .place = {}}}}});
  Diagnostics diagnostics("keys");
  SectionBinders sections(document, diagnostics);
  DirectionRequest request;
  bind_sections(sections, {&world, 1}, request);
  CHECK(diagnostics.empty());

  std::vector<SectionKeys> listed;
  const auto list = [&](const std::string& name, const std::vector<BoundKey>& bound_keys) {
    SectionKeys keys{name, {}};
    for (const BoundKey& bound : bound_keys)
      keys.keys.push_back(bound.spec);
    listed.push_back(std::move(keys));
  };
  for (const Binder* section : sections.all()) {
    list(section->section_name(), section->keys());
    for (const BoundTables& array : section->arrays())
      list(array.name, array.specs);
  }
  return listed;
}

std::string key_table(const WorldBinding& world) {
  std::vector<SectionKeys> sections = request_keys(world);
  // Few people need [sampler], which has the most keys.
  std::stable_partition(sections.begin(), sections.end(),
                        [](const SectionKeys& keys) { return keys.name != "sampler"; });
  const Row title{"key", "unit", "range", "default", "what it is"};
  Row widest = title;
  for (const SectionKeys& section : sections) {
    for (const KeySpec& spec : section.keys) {
      const Row row = row_of(spec);
      for (std::size_t i = 0; i < row.size(); ++i) {
        if (row[i].size() > widest[i].size()) widest[i] = row[i];
      }
    }
  }
  std::string text = fmt::format("{}: {}\n", world.name, world.summary);
  for (const SectionKeys& section : sections) {
    std::vector<Row> rows;
    for (const KeySpec& spec : section.keys)
      rows.push_back(row_of(spec));
    text +=
        fmt::format("\n[{}]\n{}{}", section.name, aligned({title}, widest), aligned(rows, widest));
  }
  return text;
}

}  // namespace sleight::request
