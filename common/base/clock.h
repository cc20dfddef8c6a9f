// Time as an interface, so that code with time-outs is tested without waiting.
//
// No clock's value may enter an archive (docs/DETERMINISM). Clocks determine progress lines, time
// limits and the sizes of work units. These never change a result.
#pragma once

namespace sleight::base {

/// Thread-safe.
class Clock {
 public:
  virtual ~Clock() = default;
  /// Returns seconds since an arbitrary moment, never decreasing.
  virtual double now_s() const = 0;
};

class SteadyClock final : public Clock {
 public:
  double now_s() const override;
};

/// A clock that continues while the machine sleeps, because other machines may act during the
/// sleep.
class BootClock final : public Clock {
 public:
  double now_s() const override;
};

double thread_processor_s();

/// A clock for tests, whose time changes only when a test sets it. Not thread-safe.
class ManualClock final : public Clock {
 public:
  double now_s() const override { return now_s_; }
  void advance(double seconds) { now_s_ += seconds; }

 private:
  double now_s_ = 0;
};

}  // namespace sleight::base
