// An error in a request, with its place: `requests/hi.toml:12:9: unknown key 'lamda' in ...`.
//
// Lines and columns count from 1; columns count characters (code points), not bytes, so a tab and
// an accented letter are one column each. The place is that of
//   - the key, where the key is the matter: unknown, given in the wrong section, at odds with
//     another key; a section counts as a key, so [world] is placed at its `w`;
//   - the value, where the value is the matter: of the wrong type or out of range;
//   - the section's name, where a key is missing from it; 1:1, where the section itself is missing;
//   - the character that could not be read, where the file is not TOML.
// What an option of the command line gives has no line (0): the option stands in the file's place,
// `--set sampler.sed=1: unknown key 'sed' in ...`.
// Messages are one line without control characters, whatever the file holds.
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

/// Of what is in no file.
inline constexpr Place k_no_place{.line = 0, .column = 0};

struct Diagnostic {
  std::string file;  ///< made printable; of an error in no file, what gave it
  Place place;
  std::string message;
  friend bool operator==(const Diagnostic&, const Diagnostic&) = default;
};

/// `file:line:column: message`, in no file `file: message`; without a line end.
std::string to_string(const Diagnostic& diagnostic);

/// More than these are counted, not shown: a hostile file must not fill a terminal or a log.
inline constexpr std::size_t k_diagnostics_max = 200;

/// Gathers the errors of one file. Not thread-safe.
class Diagnostics {
 public:
  explicit Diagnostics(std::string_view file);

  void add(Place place, std::string message);
  bool empty() const { return found_.empty(); }

  /// All errors by place, those of one place in the order in which they were added. Beyond
  /// k_diagnostics_max a last one says how many more there are.
  std::vector<Diagnostic> sorted() const;

 private:
  std::string file_;
  std::vector<Diagnostic> found_;
};

}  // namespace sleight::request
