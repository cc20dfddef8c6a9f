// An error in a request with its place: `requests/hi.toml:12:9: unknown key 'lamda' in ...`.
//
// Lines and columns count from 1. A column is a character (code point), not a byte. So a tab or an
// accented letter is one column. The place is
//
//   - the key, if the key is unknown, is in the wrong section, or conflicts with another key; a
//     section counts as a key, so [world] is placed at its `w`;
//   - the value, if it has the wrong type or is out of range;
//   - the section's name, if a key is missing in it, or 1:1 if the section is missing;
//   - the unreadable character, if the file is not TOML.
//
// A value from the command line has line 0. The option then replaces the file name: `--set
// sampler.sed=1: unknown key 'sed' in ...`. Messages are one line without control characters,
// whatever the file contains.
#pragma once

#include <compare>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace sleight::request {

struct Place {
  std::uint32_t line = 1;
  std::uint32_t column = 1;
  friend auto operator<=>(const Place&, const Place&) = default;
};

/// Place of a value that doesn't come from a file.
inline constexpr Place k_no_place{.line = 0, .column = 0};

struct Diagnostic {
  std::string file;  ///< printable file name, or the option that gave the value
  Place place;
  std::string message;
  friend bool operator==(const Diagnostic&, const Diagnostic&) = default;
};

/// Returns `file:line:column: message`, or `file: message` if there is no line. The text has no
/// line end.
std::string to_string(const Diagnostic& diagnostic);

/// Maximum errors that are shown. Further errors are only counted, so that a hostile file can't
/// fill a terminal or a log.
inline constexpr std::size_t k_diagnostics_max = 200;

/// Collects the errors of one file. Not thread-safe.
class Diagnostics {
 public:
  explicit Diagnostics(std::string_view file);

  void add(Place place, std::string message);
  bool empty() const { return found_.empty(); }

  /// Returns all errors, sorted by place. If several errors have the same place, they keep the
  /// order of their addition. If there are more than k_diagnostics_max errors, the last entry has
  /// the number of further errors.
  std::vector<Diagnostic> sorted() const;

 private:
  std::string file_;
  std::vector<Diagnostic> found_;
};

}  // namespace sleight::request
