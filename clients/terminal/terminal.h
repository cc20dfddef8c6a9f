// What this process's terminal is, and who people are.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <optional>
#include <string>
#include <string_view>

namespace sleight::terminal {

/// Characters in a line of the stream's terminal; none where it is no terminal.
std::optional<std::size_t> width_of(std::FILE* stream);

/// A line that renews itself, on a terminal that has escape codes. Belongs to one thread.
class RenewedLine {
 public:
  explicit RenewedLine(std::FILE* stream);
  /// False: elsewhere than on such a terminal, where plain lines are for.
  bool can_renew() const { return can_renew_; }
  /// REQUIRES: can_renew().
  void show(std::string_view line);
  /// Takes it away, so that another line can take its place.
  void clear();
  /// Ends it, so that what follows begins on a new one.
  void finish();

 private:
  std::FILE* stream_;
  bool can_renew_ = false;
  bool is_open_ = false;
};

/// Whether stdin is a terminal.
bool is_typed();

/// Whether a person can be asked: stdin and stderr are terminals.
bool can_ask();

/// Asks on stderr, reads a line of stdin; whether it begins with y or Y.
bool ask(const std::string& question);

/// A user's name, or the number where there is none.
std::string name_of_user(std::uint32_t uid);

/// A uid of a name or a number.
std::optional<std::uint32_t> user_of(const std::string& text);

}  // namespace sleight::terminal
