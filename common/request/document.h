// A request file as sections of keys with their places. The rest of this folder uses these
// sections, so that only one source file compiles toml++.
//
// Invariants
//   1. Section names are distinct, and a section's keys are distinct (TOML forbids duplicates).
//   2. Sections and keys are ordered by place.
//   3. Every place is inside the file, or just behind a line's last character.
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

struct Entry;
struct Value;

struct DateOrTime {};

/// A section `[name]`, or a table in a section, whatever its notation.
struct Section {
  std::string name{};  ///< empty for a table in a section
  Place place{};
  std::vector<Entry> entries;

  /// Returns null if there is no such key.
  const Entry* find(std::string_view key) const;
  /// Returns the table `[section.key]`, or null if the key is omitted or has another value.
  const Section* table(std::string_view key) const;
  /// Returns the tables `[[section.key]]` in order. Empty: the key is omitted or has another value.
  std::vector<const Section*> tables(std::string_view key) const;
};

struct Value {
  std::variant<std::string, std::int64_t, double, bool, DateOrTime, std::vector<Value>, Section>
      held;
  Place place;
};

struct Entry {
  std::string key;
  Place place;
  Value value;
};

struct Document {
  std::vector<Section> sections;
  std::vector<Entry> loose;  ///< keys before the first section, and arrays given as sections

  /// Returns null if there is no such section.
  const Section* find(std::string_view name) const;
};

inline constexpr std::size_t k_request_bytes_max = std::size_t{1} << 20;
/// Maximum number of dots on one line. Only dots that may be part of a dotted key are counted. A
/// dotted key nests once per dot, and toml++ 3.3 frees nested tables recursively. A megabyte of
/// `a.a.a` would overflow the stack. The decimal points of numbers aren't counted. A number has one
/// dot, so in a key such as `1.1 . 1.1 . 1.1` at least every second dot is counted.
inline constexpr std::size_t k_dots_per_line_max = 100;

/// Reads TOML 1.0. Stops at the first error: invalid UTF-8, invalid TOML, duplicate keys, more than
/// k_request_bytes_max bytes, or more than k_dots_per_line_max dots.
base::Result<Document, Diagnostic> parse_document(std::string_view text, std::string_view file);

/// Describes a value, for messages with "found ...": `the string "4"`, `1.5`, `an array`. Printable
/// and short.
std::string description(const Value& value);

}  // namespace sleight::request
