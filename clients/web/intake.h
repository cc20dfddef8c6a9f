// The requests of one connection: bytes go in, requests that have passed the guard come out, one at
// a time.
//
// The class has no socket and no clock, so that tests and fuzzers run the server's own code. Usage:
//
//   while (true) switch (intake.step()) {
//     case Step::more:    read into intake.room(), then intake.got(count)
//     case Step::proceed: send "100 Continue"
//     case Step::whole:   answer intake.passed(), then intake.next()
//     case Step::refused: answer intake.refusal(), and close
//   }
//
// Invariants:
//
//   1. The guard judges a head before any of the body is stored.
//   2. An intake stores at most k_buffer_bytes and a body. The bodies of all connections
//      together are within their BodyBudget.
//   3. Bytes after a request stay in the buffer until next().
//
// Thread safety: none. Other threads may read a BodyBudget.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

#include "clients/web/guard.h"

namespace sleight::web {

/// Maximum number of unparsed bytes of a connection.
inline constexpr std::size_t k_buffer_bytes = 64U << 10U;

/// Memory used by the bodies of all connections.
struct BodyBudget {
  std::size_t bytes_max = 0;
  std::atomic<std::size_t> bytes = 0;
};

struct IntakeLimits {
  std::size_t head_bytes_max = 16U << 10U;
  std::size_t body_bytes_max = 4U << 20U;
};

/// What the caller must do next.
enum class Step : std::uint8_t { more, proceed, whole, refused };

class Intake {
 public:
  /// `guard` and `budget` must outlive the intake. REQUIRES: head_bytes_max < k_buffer_bytes.
  Intake(const Guard& guard, const IntakeLimits& limits, BodyBudget& budget);
  ~Intake();
  Intake(const Intake&) = delete;
  Intake& operator=(const Intake&) = delete;

  /// Where to read bytes into. REQUIRES: the last step was `more`.
  std::span<char> room();
  /// Reports the number of bytes read. REQUIRES: `count` is at most the size of room().
  void got(std::size_t count);

  Step step();

  /// The request, with its body. REQUIRES: the last step was `whole`.
  Passed& passed();
  /// Whether the client keeps the connection open for another request. REQUIRES: as passed().
  bool keeps_open() const;
  /// REQUIRES: the last step was `refused`.
  const Refusal& refusal() const;
  /// Starts the next request. REQUIRES: the last step was `whole`.
  void next();

  /// Whether no byte of a request has arrived.
  bool is_idle() const;
  /// Whether a head has passed the guard and its body is arriving.
  bool is_in_body() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace sleight::web
