// A lock for disks that several machines share, where flock holds on one machine or not at all: a
// lease that its holder renews, in a file.
//
// Every hold of the lock has a number, its generation, and a file `lease.N`. Making that file is
// the only step that decides: it succeeds for one process alone, as link(2) does. Whoever wants the
// lock looks at the newest file and makes the next one, if the newest one's holder has let go, is
// known to be dead, or has not renewed for a whole lease. Nothing is ever taken away from a holder:
// a lock file that is renamed or removed leaves a moment without one, in which a third process
// takes the lock while the second thinks that it has it.
//
// Time is each process's own, and no two machines' clocks are compared. The holder of a lease of 60
// s (k_lease_s) renews it every 3 s by writing its file, and may act for 45 s (k_lease_held_share)
// from the moment at which the last renewal that succeeded began. An observer waits until it has
// seen the same bytes for 60 s of its own.
//
//   take:    list; read the newest file twice, a lease apart, unless its holder is gone;
//            make `lease.N+1` with my text (else: another was faster);
//            list: is mine the newest? (else: what I saw was old; withdraw)
//   renew:   begin := now; write my file; if now < end of my lease: it ends at begin + 45 s now
//            list: is mine the newest?
//   may act: now < end of my lease, and it was never lost
//
// Invariants
//   1. At no moment may two holders act. A holder's last renewal began at s and was there to be
//      read before an observer's first look at t >= s. A later one would have counted only if it
//      had been there before s + 45 s, so before the observer's last look, after t + 60 s: it would
//      have been seen. So the holder stopped at s + 45 s. The 15 s between are for clocks that run
//      at different rates.
//   2. A lease that has ended never comes back: the holder stops for good.
//   3. The newest file is never removed, so that generations only grow; older ones go.
//   4. Two processes of one machine see each other: a dead holder is noticed at once, and a live
//      one keeps the lock, whatever its lease says.
// REQUIRES of the disk: a read that begins after a write has ended sees it (NFS: close to open); a
// folder's list is up to date after an own change in it.
//
// Pure but for LeaseFiles and the clock. Thread safety: may_act from any thread; the rest
// from one at a time.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "common/base/clock.h"

namespace sleight::store {

inline constexpr double k_lease_s = 60;
/// Of a lease, as long as its holder may act.
inline constexpr double k_lease_held_share = 0.75;
/// Of a lease, the time between two renewals.
inline constexpr double k_renew_share = 0.05;
/// Of a strange file: no more is believed.
inline constexpr double k_lease_s_max = 600;

/// The process that holds a lock, or wants it.
struct LeaseHolder {
  std::string host{};         ///< its name: for people, and part of `machine`
  std::string machine{};      ///< one start of one kernel, and its process numbers; "": unknown
  std::int64_t process = 0;   ///< its number there
  std::uint64_t started = 0;  ///< ticks of its machine's clock: numbers are used again
  std::string since{};        ///< wall time, for people: when it took the lock
};

/// A lease as its file tells.
struct LeaseText {
  LeaseHolder holder{};
  std::string token{};  ///< nobody else's
  double lease_s = k_lease_s;
  std::uint64_t epoch = 0;  ///< of the run's session; 0: not known yet
  std::uint64_t beat = 0;   ///< renewals so far
  bool is_released = false;
  bool owes_copies = false;  ///< Lease::owes_copies

  /// Of k_lease_text_bytes, so that a file is always overwritten whole.
  std::string to_text() const;
  /// None where it isn't one.
  static std::optional<LeaseText> from_text(const std::string& text);
};
inline constexpr std::size_t k_lease_text_bytes = 1024;

/// What a lease does to the disk and asks of its machine. A test stands in for them; the real ones
/// are in lease_files.h. Functions throw base::Error where the disk fails.
class LeaseFiles {
 public:
  /// A lease's own file, open for writing: never another's that has got its name.
  class Own {
   public:
    virtual ~Own() = default;
    /// Replaces its text, and returns when the server has it.
    virtual void write(const std::string& text) = 0;
  };

  virtual ~LeaseFiles() = default;
  /// Generations that have a file, ascending.
  virtual std::vector<std::uint64_t> list() = 0;
  /// None where there is no such file.
  virtual std::optional<std::string> read(std::uint64_t generation) = 0;
  /// Makes a generation's file with this text, which no other has; null if it is there already.
  virtual std::unique_ptr<Own> make(std::uint64_t generation, const std::string& text) = 0;
  /// No error where there is no such file.
  virtual void remove(std::uint64_t generation) = 0;
  /// True only if it ran on this machine and does so no more.
  virtual bool is_gone(const LeaseHolder& holder) = 0;
  /// True if it runs on this machine.
  virtual bool is_here(const LeaseHolder& holder) = 0;
};

/// One lease from the wish to its end.
class Lease {
 public:
  /// Borrows both. `text`: the holder and the token; lease_s counts for this lease.
  Lease(LeaseFiles& files, const base::Clock& clock, LeaseText text);

  struct Taken {};
  /// Another has it: it was seen to renew, or runs on this machine.
  struct Held {
    std::optional<LeaseText> by{};  ///< none: a file that says nothing
  };
  /// Nothing is known yet: look again after a while.
  struct Unsure {
    std::optional<LeaseText> by{};
    double left_s = 0;  ///< until it counts as dead, if it does not renew
  };
  using Outcome = std::variant<Taken, Held, Unsure>;
  /// Tries to take it; called again and again while unsure. REQUIRES: not taken yet.
  Outcome try_take();

  /// Whether a holder on another machine never let go, so that it may write what it has open, and
  /// nobody has replaced these files since.
  bool owes_copies() const { return text_.owes_copies; }
  /// They are replaced; is known to others with the next renewal.
  void set_copied() { text_.owes_copies = false; }

  /// Writes that the holder lives. True if it may act on; a disk that failed is tried again by the
  /// next call, until the lease ends. REQUIRES: taken.
  bool renew();
  /// With the next renewal.
  void set_epoch(std::uint64_t epoch) { text_.epoch = epoch; }
  /// Lets go: the next one takes it at once. Does nothing where it was not taken, or has ended.
  /// REQUIRES: nothing is done any more that the lock is for.
  void release();

  /// Whether what the lock protects may be changed now.
  bool may_act() const;
  /// Whoever has taken the lock from this one, where that is known.
  std::optional<LeaseText> successor();

  double renew_every_s() const { return text_.lease_s * k_renew_share; }

 private:
  Outcome take(std::uint64_t generation, bool owes_copies);
  double held_s() const { return text_.lease_s * k_lease_held_share; }

  LeaseFiles& files_;
  const base::Clock& clock_;
  LeaseText text_;
  std::uint64_t generation_ = 0;  ///< 0: not taken
  std::unique_ptr<LeaseFiles::Own> own_;
  std::atomic<double> end_s_ = 0;
  std::atomic<bool> is_lost_ = false;

  /// What was seen of another's lease, and since when.
  struct Seen {
    std::uint64_t generation = 0;
    std::string text{};
    double since_s = 0;
  };
  std::optional<Seen> seen_;
};

}  // namespace sleight::store
