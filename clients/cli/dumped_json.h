// JSON as every command prints it.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

namespace sleight::cli {

/// Indented text. A path need not be UTF-8; JSON must be, so what is not is replaced.
std::string dumped(const nlohmann::ordered_json& json);

}  // namespace sleight::cli
