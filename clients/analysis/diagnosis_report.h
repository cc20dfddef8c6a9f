// Formats a diagnosis as aligned text for people, or as JSON.
#pragma once

#include <string>

#include "clients/analysis/diagnosis.h"
#include "common/json/value.h"

namespace sleight::analysis {

/// Ends with a line break. Names and texts need no escaping: the archive's reader has refused
/// anything but plain text.
std::string for_people(const std::string& path, const Diagnosis& diagnosis);

/// Unknown numbers are null.
json::Value as_json(const std::string& path, const Diagnosis& diagnosis);

}  // namespace sleight::analysis
