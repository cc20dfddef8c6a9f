// Formats JSON for all commands.
#pragma once

#include <string>

#include "common/json/value.h"

namespace sleight::report {

/// Returns indented text. Replaces invalid UTF-8, which paths may contain.
std::string dumped(const json::Value& json);

}  // namespace sleight::report
