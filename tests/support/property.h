// Property tests check a claim in many random cases. A failed case prints a command to repeat it.
//
//   for (const std::uint64_t n : property::cases(300)) {
//     random::Stream stream({.seed = k_seed, .purpose = random::Purpose::prior}, n);
//     ...
//     EXPECT_LT(gap_m, 1e-6);
//   }
//
// Each case draws random numbers from its own stream, which the case's number selects. So a case
// can run without earlier cases. After a failure of case 17 the program prints:
//
//   to see it again: SLEIGHT_CASE=17 build/release/tests/tests_unit_x --gtest_filter=Suite.Name
//
// Use in_turn() for cases that share a stream or depend on earlier cases. The command then runs all
// cases up to the failed case. If a test has no such loops, its command names no case.
//
// Environment variables select what runs:
//   - `SLEIGHT_ALL=1` runs as many cases as deploy/test --all (of_tier).
//   - `SLEIGHT_SOAK=1` runs as many cases as deploy/soak. The printed command repeats this setting
//     and SLEIGHT_ALL.
//   - `SLEIGHT_CASE=n` runs only case n of each loop. Loops over in_turn() run all cases up to n.
//   - `SLEIGHT_FAIL_CASE=n` makes case n fail, to show a failure's output.
//
// Rules
//   1. Loops over cases don't nest, and their bodies run in one thread. Threads that a body starts
//      and joins may report failures too.
//   2. If an expectation is about all cases together, check it only if all_cases() is true. If the
//      build has sanitizers, a loop runs only the first quarter of its cases, but at least ten
//      cases.
//   3. tests/support/main.cpp prints the commands, also for a CHECK, a crash or an exception.
#pragma once

#include <cstdint>

namespace sleight::property {

/// Whether cases can run in any order, or each case needs all earlier cases.
enum class Order : std::uint8_t { any, in_turn };

/// The case numbers from `first` to `last` - 1, or the number that SLEIGHT_CASE selects.
class Cases {
 public:
  Cases(std::uint64_t first, std::uint64_t last, Order order);
  ~Cases();
  Cases(const Cases&) = delete;
  Cases& operator=(const Cases&) = delete;

  class Iterator {
   public:
    explicit Iterator(std::uint64_t number) : number_(number) {}
    /// Begins the case.
    std::uint64_t operator*() const;
    Iterator& operator++() {
      ++number_;
      return *this;
    }
    bool operator!=(const Iterator& other) const { return number_ != other.number_; }

   private:
    std::uint64_t number_;
  };
  Iterator begin() const { return Iterator(first_); }
  Iterator end() const { return Iterator(last_); }

 private:
  std::uint64_t first_;
  std::uint64_t last_;
  int exceptions_;  ///< Active exceptions when the loop began.
};

/// Cases 0 to count - 1.
inline Cases cases(std::uint64_t count) {
  return {0, count, Order::any};
}

/// Cases 1 to count. Case numbers can be seeds, because no number is 0.
inline Cases seeds(std::uint64_t count) {
  return {1, count + 1, Order::any};
}

/// Cases that need earlier cases. REQUIRES: no earlier loop of the test uses the same stream.
inline Cases in_turn(std::uint64_t count) {
  return {0, count, Order::in_turn};
}

/// Returns whether all cases run. Only then do expectations about many cases together hold.
bool all_cases();

/// Returns whether tests run as many cases as in deploy/soak.
bool long_run();

/// Returns `fast` in deploy/test, and `all` in deploy/test --all and deploy/soak.
std::uint64_t of_tier(std::uint64_t fast, std::uint64_t all);

}  // namespace sleight::property
