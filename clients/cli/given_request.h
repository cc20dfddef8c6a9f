// A request as people give it: a file, standard input, or a word.
#pragma once

#include <optional>
#include <string>

#include "common/request/direction_request.h"

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

/// What a job of it is called: the file's name without its ending, the word, or "request".
std::string short_name_of(const std::string& path, const std::string& word);

}  // namespace sleight::cli
