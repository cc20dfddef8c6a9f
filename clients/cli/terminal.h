// What this process's terminal is, and who people are.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <optional>
#include <string>

namespace sleight::cli {

/// Characters in a line of the stream's terminal; none where it is no terminal.
std::optional<std::size_t> width_of(std::FILE* stream);

/// Whether a person can be asked: stdin and stderr are terminals.
bool can_ask();

/// Asks on stderr, reads a line of stdin; whether it begins with y or Y.
bool ask(const std::string& question);

/// A user's name, or the number where there is none.
std::string name_of_user(std::uint32_t uid);

/// A uid of a name or a number.
std::optional<std::uint32_t> user_of(const std::string& text);

}  // namespace sleight::cli
