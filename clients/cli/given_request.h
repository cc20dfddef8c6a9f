// A request as people give it: a file, standard input, or a word.
#pragma once

#include <optional>
#include <span>
#include <string>

#include "common/request/direction_request.h"
#include "common/request/sets.h"

namespace sleight::cli {

/// What errors call it, and its text.
struct GivenRequest {
  std::string name{};
  std::string text{};
};

/// Reads the file, or standard input where `path` is "-"; where it is empty, makes the shortest
/// request for `word`. Throws base::Error: usage where there is neither, environment where it can't
/// be read.
GivenRequest given_request(const std::string& path, const std::string& word,
                           const std::optional<request::Asked>& asked);

/// Options that give what a key of the request gives.
struct OptionsGiven {
  bool seed = false;
  bool word = false;
  std::string answer{};  ///< "--found -n 3", in place of [stop]; empty: not given
};

/// The error of a --set whose key an option gives, too: the option would win in silence.
std::optional<request::Diagnostic> given_twice(std::span<const request::KeySet> sets,
                                               const OptionsGiven& options);

/// What a job of it is called: the file's name without its ending, the word, or "request".
std::string short_name_of(const std::string& path, const std::string& word);

}  // namespace sleight::cli
