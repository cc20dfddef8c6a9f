#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "common/request/common_sections.h"
#include "common/request/direction_request.h"

namespace sleight::request {
namespace {

constexpr std::size_t k_columns = 5;
using Row = std::array<std::string, k_columns>;

/// Maximum width of the column of ranges. A longer range is in the last column; such ranges have
/// many names.
constexpr std::size_t k_range_characters_max = 24;
constexpr std::size_t k_help_characters = 60;

Row row_of(const KeySpec& spec) {
  const std::string fallback = spec.presence == Presence::required   ? "required"
                               : spec.presence == Presence::optional ? "none"
                                                                     : spec.fallback;
  const bool is_long = spec.range.size() > k_range_characters_max;
  return {spec.key, spec.unit.empty() ? "-" : spec.unit, is_long ? "see meaning" : spec.range,
          fallback, is_long ? fmt::format("{}: {}", spec.help, spec.range) : spec.help};
}

/// Removes the next line from `text` and returns it. A line has as many words as fit, but at least
/// one.
std::string_view next_line(std::string_view& text, std::size_t characters_max) {
  std::size_t end = text.size();
  if (end > characters_max) {
    end = text.rfind(' ', characters_max);
    if (end == std::string_view::npos) end = std::min(text.find(' '), text.size());
  }
  const std::string_view line = text.substr(0, end);
  text.remove_prefix(std::min(end + 1, text.size()));
  return line;
}

/// Pads columns to their widest entry, two spaces apart. The last column is wrapped.
std::string aligned(const std::vector<Row>& rows) {
  std::array<std::size_t, k_columns> widest{};
  for (const Row& row : rows) {
    for (std::size_t i = 0; i < row.size(); ++i)
      widest[i] = std::max(widest[i], row[i].size());
  }
  std::string text;
  for (const Row& row : rows) {
    text += ' ';
    for (std::size_t i = 0; i + 1 < row.size(); ++i) {
      text += fmt::format(" {:<{}} ", row[i], widest[i]);
    }
    const std::size_t indent = text.size() - text.rfind('\n') - 1;
    std::string_view help = row.back();
    text += fmt::format(" {}\n", next_line(help, k_help_characters));
    while (!help.empty())
      text += fmt::format("{:{}} {}\n", "", indent, next_line(help, k_help_characters));
  }
  return text;
}

void list(const std::string& name, const BoundSection& bound, std::vector<SectionKeys>& listed) {
  SectionKeys keys{name, {}};
  for (const BoundKey& key : bound.keys)
    keys.keys.push_back(key.spec);
  listed.push_back(std::move(keys));
  for (const BoundTables& tables : bound.tables)
    list(tables.name, tables.described, listed);
}

}  // namespace

std::vector<SectionKeys> request_keys(const WorldBinding& world) {
  // Bind a request that has only this world's name. Every key then has its default. The world may
  // require more, but its errors don't change the list.
  Document document;
  document.sections.push_back(
      {.name = "world", .entries = {{"name", {}, {.held = world.name, .place = {}}}}});
  Diagnostics diagnostics("keys");
  SectionBinders sections(document, diagnostics);
  DirectionRequest request;
  bind_sections(sections, {&world, 1}, request);

  std::vector<SectionKeys> listed;
  for (const Binder* section : sections.all())
    list(section->section_name(), section->bound(), listed);
  return listed;
}

std::string key_table(const WorldBinding& world) {
  std::vector<SectionKeys> sections = request_keys(world);
  // Print [sampler] last, because it has the most keys and few people need them.
  std::stable_partition(sections.begin(), sections.end(),
                        [](const SectionKeys& keys) { return keys.name != "sampler"; });
  const Row title{"key", "unit", "range", "default", "meaning"};
  std::string text = fmt::format("{}: {}\n", world.name, world.summary);
  for (const SectionKeys& section : sections) {
    std::vector<Row> rows{title};
    for (const KeySpec& spec : section.keys)
      rows.push_back(row_of(spec));
    text += fmt::format("\n[{}]\n{}", section.name, aligned(rows));
  }
  return text;
}

}  // namespace sleight::request
