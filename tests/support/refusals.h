// Helper for tests of calls that must fail.
#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <string>

#include "common/base/error.h"
#include "tests/support/facts.h"

namespace sleight::tests {

/// Calls work(), which must throw an error that contains `words` (a part of the message, or facts
/// as in facts.h). Returns the error's exit code.
inline base::ExitCode failure_of(const std::function<void()>& work, const std::string& words) {
  try {
    work();
  } catch (const base::Error& error) {
    EXPECT_THAT(error.what(), ::testing::AnyOf(::testing::HasSubstr(words), HasFacts(words)));
    return error.exit_code();
  }
  ADD_FAILURE() << "not refused: " << words;
  return base::ExitCode::ok;
}

}  // namespace sleight::tests
