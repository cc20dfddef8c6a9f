// Queries this process's terminal and users' names.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <optional>
#include <string>
#include <string_view>

namespace sleight::terminal {

/// Returns the width of the stream's terminal in characters. Nothing if it isn't a terminal.
std::optional<std::size_t> width_of(std::FILE* stream);

/// A terminal line that escape codes update in place. Not thread-safe.
class RenewedLine {
 public:
  explicit RenewedLine(std::FILE* stream);
  /// Returns false if the stream isn't a terminal with escape codes; print plain lines instead.
  bool can_renew() const { return can_renew_; }
  /// REQUIRES: can_renew().
  void show(std::string_view line);
  /// Removes the line, so that another line can replace it.
  void clear();
  /// Ends the line, so that further output begins on a new line.
  void finish();

 private:
  std::FILE* stream_;
  bool can_renew_ = false;
  bool is_open_ = false;
};

/// Whether stdin is a terminal.
bool is_typed();

/// Whether stdin and stderr are terminals, so that a person can be asked.
bool can_ask();

/// Asks on stderr and reads a line from stdin. Returns whether the answer begins with y or Y.
bool ask(const std::string& question);

/// Returns a user's name, or the number if there is no name.
std::string name_of_user(std::uint32_t uid);

/// Returns the uid of a name or a number.
std::optional<std::uint32_t> user_of(const std::string& text);

}  // namespace sleight::terminal
