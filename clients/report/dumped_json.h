// JSON as every command prints it.
#pragma once

#include <string>

#include "common/json/value.h"

namespace sleight::report {

/// Indented text. A path need not be UTF-8; JSON must be, so what is not is replaced.
std::string dumped(const json::Value& json);

}  // namespace sleight::report
