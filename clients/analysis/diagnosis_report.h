// A diagnosis for people, as aligned text, and for programs, as JSON.
#pragma once

#include <string>

#include "clients/analysis/diagnosis.h"
#include "common/json/value.h"

namespace sleight::analysis {

/// Ends with a line break. Names and texts of an archive are plain words and lines: the reader
/// refuses others.
std::string for_people(const std::string& path, const Diagnosis& diagnosis);

/// Numbers that can't be given are null.
json::Value as_json(const std::string& path, const Diagnosis& diagnosis);

}  // namespace sleight::analysis
