// Property tests: a claim is tried on many random cases, and a case that fails prints the command
// that repeats it alone.
//
//   for (const std::uint64_t n : property::cases(300)) {
//     random::Stream stream({.seed = k_seed, .purpose = random::Purpose::prior}, n);
//     ...
//     EXPECT_LT(gap_m, 1e-6);
//   }
//
// Each case takes its random numbers from a stream of its own, addressed by the case's number, so
// that one runs without those before it. A failure of case 17 is followed by
//
//   to see it again: SLEIGHT_CASE=17 build/release/tests/tests_unit_x --gtest_filter=Suite.Name
//
// Cases that take their numbers from one stream, or go on from one another, are `in_turn`: the
// command runs those up to the one that failed. A test without such a loop is named without a case,
// which repeats it too, since seeds are fixed.
//
// The environment says what runs:
//   SLEIGHT_ALL=1        as many cases as deploy/test --all asks for (of_tier)
//   SLEIGHT_SOAK=1       as many cases as deploy/soak asks for
//                        (the command above repeats either)
//   SLEIGHT_CASE=n       case n alone, in each loop that has it; of cases in turn all up to it
//   SLEIGHT_FAIL_CASE=n  case n fails, whatever comes of it: shows what a failure prints
//
// Numbered rules:
//   1. Loops over cases don't nest, and their bodies run in one thread. Threads that a body starts
//      and joins may fail too.
//   2. What is expected of all cases together is asked only where `all_cases()`.
//      With sanitizers a loop has the first quarter of its cases, and at least ten: the claim is
//      the release build's to test, memory and undefined behaviour theirs.
//   3. tests/support/main.cpp prints the commands, also for a CHECK, a crash or an exception.
#pragma once

#include <cstdint>

namespace sleight::property {

/// Whether a case needs those before it.
enum class Order : std::uint8_t { any, in_turn };

/// The numbers first, first + 1, ... below last; with SLEIGHT_CASE that one alone, where it is
/// among them. For a range-based `for`.
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
  int exceptions_;  ///< under way when the loop began
};

/// Cases 0 to count - 1.
inline Cases cases(std::uint64_t count) {
  return {0, count, Order::any};
}

/// Cases 1 to count, for what is made from a seed, which isn't 0.
inline Cases seeds(std::uint64_t count) {
  return {1, count + 1, Order::any};
}

/// Cases 0 to count - 1, of which each needs those before it. REQUIRES: no other loop of the test
/// takes numbers from the same stream before.
inline Cases in_turn(std::uint64_t count) {
  return {0, count, Order::in_turn};
}

/// False where SLEIGHT_CASE names one, and with sanitizers, which run a part: what many cases
/// together must come to is not to be asked.
bool all_cases();

/// Whether tests run at the length of deploy/soak.
bool long_run();

/// `fast` in deploy/test; `all` in deploy/test --all and deploy/soak.
std::uint64_t of_tier(std::uint64_t fast, std::uint64_t all);

}  // namespace sleight::property
