#include "clients/cli/config_command.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>
#include <string>
#include <system_error>
#include <vector>

#include "common/config/settings.h"
#include "common/json/value.h"

namespace sleight::cli {
namespace {

/// Returns "default" or a setting's source. If the source is the settings file, returns "file" and
/// the line number. The file's path is printed below all settings.
std::string source_of(const config::Row& row, const std::optional<std::string>& path) {
  if (row.origin == config::Origin::fallback) return "default";
  if (row.origin == config::Origin::file && path && row.given_by.starts_with(*path))
    return "file" + row.given_by.substr(path->size());
  return row.given_by;
}

json::Value value_of(const config::Row& row) {
  if (row.is_text) return row.value;
  if (row.is_flag) return row.value == "true";
  if (!row.number) return nullptr;
  if (*row.number == std::floor(*row.number)) return static_cast<std::int64_t>(*row.number);
  return *row.number;
}

void print_json(const std::vector<config::Row>& rows, const std::optional<std::string>& path,
                bool is_there) {
  json::Value settings = json::Value::object();
  for (const config::Row& row : rows) {
    settings[row.key] = {{"value", value_of(row)},
                         {"unit", row.unit},
                         {"from", config::name_of(row.origin)},
                         {"given_by", row.given_by}};
  }
  const json::Value json{
      {"file", path.value_or("")}, {"file_is_there", is_there}, {"settings", settings}};
  fmt::print("{}\n", json.dump(2));
}

}  // namespace

int print_config(bool json) {
  const config::Settings settings = config::settings_here();
  const std::vector<config::Row> rows = config::rows_of(settings);
  const std::optional<std::string> path = config::config_path_of(config::surroundings_here());
  std::error_code none;
  const bool is_there = path && std::filesystem::exists(*path, none);
  if (json) {
    print_json(rows, path, is_there);
    return 0;
  }
  std::size_t key_width = 0;
  std::size_t value_width = 0;
  std::size_t source_width = 0;
  for (const config::Row& row : rows) {
    key_width = std::max(key_width, row.key.size());
    value_width = std::max(value_width, row.value.size());
    source_width = std::max(source_width, source_of(row, path).size());
  }
  for (const config::Row& row : rows) {
    fmt::print("{:<{}}  {:<{}}  {:<{}}  {}\n", row.key, key_width, row.value, value_width,
               source_of(row, path), source_width, row.help);
  }
  if (path) fmt::print("\nSettings file: {}{}\n", *path, is_there ? "" : " (does not exist)");
  return 0;
}

}  // namespace sleight::cli
