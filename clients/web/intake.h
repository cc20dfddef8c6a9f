// One connection's requests: bytes go in, asks that have passed the guard come out, one at a time.
//
// It knows no socket and no clock, so that tests and fuzzers run just what a server runs.
//
//   while (true) switch (intake.step()) {
//     case Step::more:    read into intake.room(), then intake.got(count)
//     case Step::proceed: send "100 Continue"
//     case Step::whole:   answer intake.passed(), then intake.next()
//     case Step::refused: answer intake.refusal(), and close
//   }
//
// Invariants
//   1. The guard judges a head before anything of a body is kept.
//   2. It holds at most k_buffer_bytes and a body; bodies of all connections together are within
//      their BodyBudget.
//   3. Bytes behind a request stay in the buffer until next().
//
// Thread safety: none; a BodyBudget may be read by other threads.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

#include "clients/web/guard.h"

namespace sleight::web {

/// Bytes of a connection that are not taken apart yet.
inline constexpr std::size_t k_buffer_bytes = 64U << 10U;

/// What bodies of all connections hold.
struct BodyBudget {
  std::size_t bytes_max = 0;
  std::atomic<std::size_t> bytes = 0;
};

struct IntakeLimits {
  std::size_t head_bytes_max = 16U << 10U;
  std::size_t body_bytes_max = 4U << 20U;
};

/// What is to be done next.
enum class Step : std::uint8_t { more, proceed, whole, refused };

class Intake {
 public:
  /// `guard` and `budget` must outlive it. REQUIRES: head_bytes_max < k_buffer_bytes.
  Intake(const Guard& guard, const IntakeLimits& limits, BodyBudget& budget);
  ~Intake();
  Intake(const Intake&) = delete;
  Intake& operator=(const Intake&) = delete;

  /// Where bytes are to be read into. REQUIRES: the last step was `more`.
  std::span<char> room();
  /// So many are there. REQUIRES: no more than room() had.
  void got(std::size_t count);

  Step step();

  /// With its body. REQUIRES: the last step was `whole`.
  Passed& passed();
  /// Whether its sender wants the connection for another request; likewise.
  bool keeps_open() const;
  /// REQUIRES: the last step was `refused`.
  const Refusal& refusal() const;
  /// On to the next request. REQUIRES: the last step was `whole`.
  void next();

  /// Nothing of a request has come.
  bool is_idle() const;
  /// A head has passed, and its body is on the way.
  bool is_in_body() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace sleight::web
