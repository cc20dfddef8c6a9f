// A request file as sections of keys, each with its place; what the rest of this folder reads
// instead of TOML, so that toml++ is compiled in one source file.
//
// Invariants
//   1. Section names are distinct, and so are the keys of a section (TOML forbids doubles); the
//      tables of an array all have its name.
//   2. Sections and keys are in the order of their places.
//   3. Every place lies in the file, or just behind a line's last character.
// Values; thread-safe as such.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "common/base/result.h"
#include "common/request/diagnostic.h"

namespace sleight::request {

/// A value that no key of a request can have.
enum class Unwanted { array, table, date_or_time };

struct Value {
  std::variant<std::string, std::int64_t, double, bool, Unwanted> held;
  Place place;
};

struct Entry {
  std::string key;
  Place place;
  Value value;
};

struct Section;

/// `[[section.key]]`, as often as it stands in the file. The section has an entry of this key, too:
/// an array.
struct TableArray {
  std::string key;
  std::vector<Section> tables;  ///< in order; named as they are written between brackets
};

struct Section {
  std::string name;
  Place place;
  std::vector<Entry> entries;
  std::vector<TableArray> arrays{};

  /// Null if there is no such key.
  const Entry* find(std::string_view key) const;
  /// Null if there is no such array of tables.
  const TableArray* find_array(std::string_view key) const;
};

struct Document {
  std::vector<Section> sections;
  std::vector<Entry> loose;  ///< keys before the first section, and sections given as arrays

  /// Null if there is no such section.
  const Section* find(std::string_view name) const;
};

inline constexpr std::size_t k_request_bytes_max = std::size_t{1} << 20;
/// Dots on one line that a key may follow. A dotted key nests as deep as it has dots, and
/// toml++ 3.3 frees nested tables by recursion without a limit: a megabyte of `a.a.a` would
/// overflow the stack.
inline constexpr std::size_t k_dots_per_line_max = 100;

/// Reads TOML 1.0. What fails is reported alone, being where reading ended: not UTF-8, not TOML,
/// doubled keys, longer than k_request_bytes_max, more dots of keys than k_dots_per_line_max.
base::Result<Document, Diagnostic> parse_document(std::string_view text, std::string_view file);

/// As in "found ...": `found the string "4"`, `found 1.5`, `found an array`. Printable and short.
std::string description(const Value& value);

}  // namespace sleight::request
