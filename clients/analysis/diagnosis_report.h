// Formats a diagnosis as aligned text for people, or as JSON.
#pragma once

#include <string>

#include "clients/analysis/diagnosis.h"
#include "common/json/value.h"

namespace sleight::analysis {

/// Ends with a line break. The archive's reader accepts only plain text for names and texts.
std::string for_people(const std::string& path, const Diagnosis& diagnosis);

/// Unknown numbers are null.
json::Value as_json(const std::string& path, const Diagnosis& diagnosis);

}  // namespace sleight::analysis
