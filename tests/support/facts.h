// Matchers that compare messages by their facts, so that rewording a sentence breaks no test. Facts
// are names, places, numbers or short stable words. Bars separate them, as in "f:2:5: |'x'|0 to 2".
#pragma once

#include <gmock/gmock.h>

#include <cctype>
#include <sstream>
#include <string>
#include <vector>

namespace sleight::tests {

inline std::vector<std::string> parts_of(const std::string& text, char separator) {
  std::istringstream stream(text);
  std::vector<std::string> parts;
  for (std::string part; std::getline(stream, part, separator);)
    parts.push_back(part);
  return parts;
}

/// Returns whether text[at - 1] and text[at] belong to the same word or number.
inline bool is_inside_word(const std::string& text, std::size_t at) {
  const auto is = [&](int (*kind)(int), std::size_t i) {
    return i < text.size() && kind(static_cast<unsigned char>(text[i])) != 0;
  };
  const auto is_separator = [&](std::size_t i) {
    return i > 0 && is(std::isdigit, i - 1) && (text[i] == '.' || text[i] == ',') &&
           is(std::isdigit, i + 1);
  };
  if (at == 0 || at >= text.size()) return false;
  return (is(std::isalnum, at - 1) && is(std::isalnum, at)) || is_separator(at) ||
         is_separator(at - 1);
}

/// Finds `fact` in `text` at or after `from`. Returns the fact's end, or npos. The fact must not be
/// part of a longer word or number: "2" is neither in "12" nor in "2.1".
inline std::size_t end_of_fact(const std::string& text, const std::string& fact, std::size_t from) {
  for (std::size_t at = text.find(fact, from); at != std::string::npos;
       at = text.find(fact, at + 1)) {
    const std::size_t end = at + fact.size();
    if (!is_inside_word(text, at) && !is_inside_word(text, end)) return end;
  }
  return std::string::npos;
}

/// Returns the first of `facts` that `text` lacks, or an empty string. Facts must be in order.
inline std::string missing_fact(const std::string& text, const std::string& facts) {
  std::size_t at = 0;
  for (const std::string& fact : parts_of(facts, '|')) {
    at = end_of_fact(text, fact, at);
    if (at == std::string::npos) return fact;
  }
  return {};
}

MATCHER_P(HasFacts, facts, "has the facts " + ::testing::PrintToString(facts)) {
  const std::string missing = missing_fact(arg, facts);
  *result_listener << "lacks '" << missing << "'";
  return missing.empty();
}

/// Matches a text if it has as many lines as `facts` and each line has its facts. A line must start
/// with its first fact.
MATCHER_P(LinesHaveFacts, facts, "has lines with the facts " + ::testing::PrintToString(facts)) {
  const std::vector<std::string> lines = parts_of(arg, '\n');
  const std::vector<std::string> expected = parts_of(facts, '\n');
  bool match = lines.size() == expected.size();
  for (std::size_t i = 0; match && i < lines.size(); ++i) {
    match = lines[i].starts_with(parts_of(expected[i], '|').front()) &&
            missing_fact(lines[i], expected[i]).empty();
    if (!match) *result_listener << "differs in '" << lines[i] << "'";
  }
  return match;
}

}  // namespace sleight::tests
