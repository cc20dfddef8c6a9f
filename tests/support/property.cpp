#include "tests/support/property.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <charconv>
#include <cstdlib>
#include <exception>
#include <limits>
#include <stdexcept>
#include <string_view>

#include "common/base/check.h"
#include "tests/support/failures.h"

namespace sleight::property {
namespace {

constexpr std::uint64_t k_none = std::numeric_limits<std::uint64_t>::max();

/// The current case. A test program runs one test at a time, and a case's threads only read this
/// state.
struct Now {
  std::atomic<std::uint64_t> number = k_none;
  bool met = false;
  bool failed_as_asked = false;
};
Now& now() {
  static Now now;
  return now;
}

/// Returns whether this build runs only some cases. Sanitizers make cases ten times as long.
constexpr bool runs_a_part() {
#ifdef SLEIGHT_SANITIZED
  return true;
#else
  return false;
#endif
}

/// Returns how many of `count` cases this build runs.
std::uint64_t of_this_build(std::uint64_t count) {
  if (!runs_a_part() || asked().long_run) return count;
  constexpr std::uint64_t k_part = 4, k_at_least = 10;
  return std::min(count, std::max(count / k_part, k_at_least));
}

std::optional<std::uint64_t> number_in(const char* variable) {
  const char* const text = std::getenv(variable);
  if (text == nullptr) return std::nullopt;
  const std::string_view digits(text);
  std::uint64_t number = 0;
  const auto [end, error] = std::from_chars(digits.begin(), digits.end(), number);
  if (error != std::errc() || end != digits.end() || number == k_none)
    throw std::invalid_argument(fmt::format("{}={}: expected a case's number", variable, digits));
  return number;
}

}  // namespace

const Asked& asked() {
  static const Asked asked{.only_case = number_in("SLEIGHT_CASE"),
                           .failing_case = number_in("SLEIGHT_FAIL_CASE"),
                           .all = std::getenv("SLEIGHT_ALL") != nullptr,
                           .long_run = std::getenv("SLEIGHT_SOAK") != nullptr};
  return asked;
}

std::optional<std::uint64_t> current_case() {
  const std::uint64_t number = now().number;
  return number == k_none ? std::nullopt : std::optional(number);
}

void set_current_case(std::optional<std::uint64_t> number) {
  now().number = number.value_or(k_none);
}

bool only_case_was_met() {
  return now().met;
}

bool failing_case_was_met() {
  return now().failed_as_asked;
}

std::string command_of(std::string_view program, std::string_view test,
                       std::optional<std::uint64_t> number, bool long_run) {
  // If a test's name had characters other than letters and '/', the shell would need quotes.
  return fmt::format("{}{}{} --gtest_filter={}",
                     long_run      ? "SLEIGHT_SOAK=1 "
                     : asked().all ? "SLEIGHT_ALL=1 "
                                   : "",
                     number ? fmt::format("SLEIGHT_CASE={} ", *number) : "", program, test);
}

std::string path_in_project(std::string_view path) {
  constexpr std::string_view k_build = "/build/";
  const std::size_t at = path.rfind(k_build);
  return std::string(at == std::string_view::npos ? path : path.substr(at + 1));
}

Cases::Cases(std::uint64_t first, std::uint64_t last, Order order)
    : first_(first), last_(last), exceptions_(std::uncaught_exceptions()) {
  CHECK_LE(first, last);
  CHECK(!current_case());
  const auto only = asked().only_case;
  if (!only) {
    last_ = first + of_this_build(last - first);
    return;
  }
  const bool is_mine = first <= *only && *only < last;
  if (!is_mine || order == Order::any) first_ = is_mine ? *only : last;
  last_ = is_mine ? *only + 1 : last;
  now().met = now().met || is_mine;
}

Cases::~Cases() {
  // If an exception leaves the loop, keep the case set, because GoogleTest reports the exception
  // later.
  if (std::uncaught_exceptions() == exceptions_) set_current_case(std::nullopt);
}

std::uint64_t Cases::Iterator::operator*() const {
  set_current_case(number_);
  if (asked().failing_case == number_) {
    now().failed_as_asked = true;
    ADD_FAILURE() << "asked for by SLEIGHT_FAIL_CASE";
  }
  return number_;
}

bool all_cases() {
  return !asked().only_case && (!runs_a_part() || asked().long_run);
}

bool long_run() {
  return asked().long_run;
}

std::uint64_t of_tier(std::uint64_t fast, std::uint64_t all) {
  return asked().all || asked().long_run ? all : fast;
}

}  // namespace sleight::property
