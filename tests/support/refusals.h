// Helpers for work that must fail.
#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <string>

#include "common/base/error.h"
#include "tests/support/facts.h"

namespace sleight::tests {

/// Returns the exit code of work that must fail. Its error must contain `words`, which are a part
/// of the message or facts (facts.h).
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
