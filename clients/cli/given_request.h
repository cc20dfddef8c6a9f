// Reads a request from a file or standard input, or makes one from a word.
#pragma once

#include <optional>
#include <span>
#include <string>

#include "common/request/direction_request.h"
#include "common/request/sets.h"

namespace sleight::cli {

/// A request's text, and its name in errors.
struct GivenRequest {
  std::string name{};
  std::string text{};
};

/// Reads the file, or standard input if `path` is "-". If `path` is empty, makes the shortest
/// request for `word`. Throws base::Error(usage) if both are empty, and base::Error(environment)
/// if the file can't be read.
GivenRequest given_request(const std::string& path, const std::string& word,
                           const std::optional<request::Asked>& asked);

/// Command-line options that set keys of the request.
struct OptionsGiven {
  bool seed = false;
  bool word = false;
  std::string answer{};  ///< such as "--found -n 3", which replaces [stop]; empty: not given
};

/// Returns an error if a --set and another option set the same key. Otherwise the option would
/// silently replace the value of --set.
std::optional<request::Diagnostic> given_twice(std::span<const request::KeySet> sets,
                                               const OptionsGiven& options);

/// Returns a job's default name: the file's name without its extension, or the word, or "request".
std::string short_name_of(const std::string& path, const std::string& word);

}  // namespace sleight::cli
