// Time as an interface, so that logic with time-outs is tested without waiting.
//
// Nothing that a clock measured may enter an archive (docs/DETERMINISM): clocks serve progress
// lines, time limits and the sizes of work units, none of which changes a result.
#pragma once

namespace sleight::base {

/// Thread-safe.
class Clock {
 public:
  virtual ~Clock() = default;
  /// Seconds since an arbitrary moment; never goes back.
  virtual double now_s() const = 0;
};

class SteadyClock final : public Clock {
 public:
  double now_s() const override;
};

/// Goes on while the machine sleeps: what another machine may have done meanwhile hangs on it.
class BootClock final : public Clock {
 public:
  double now_s() const override;
};

/// Processor time of the calling thread, in seconds.
double thread_processor_s();

/// For tests: stands still until it is moved. Not thread-safe.
class ManualClock final : public Clock {
 public:
  double now_s() const override { return now_s_; }
  void advance(double seconds) { now_s_ += seconds; }

 private:
  double now_s_ = 0;
};

}  // namespace sleight::base
