// A lock for disks that several machines share. On such disks, flock works only within one machine,
// or not at all. So the lock is a file with a lease. The lock's holder renews the lease.
//
// Each time a process takes the lock, the lease gets a new number N, its generation. The process
// that creates the file `lease.N` has the lock. Creation, as with link(2), succeeds for exactly one
// process. A process that requests the lock reads the newest file. If the newest holder has
// released the lock, is known to be dead, or has not renewed for a whole lease, the process creates
// the next file. Nobody renames or removes the newest holder's file. Otherwise, for a moment, no
// file would exist. A third process could then take the lock while the second believes that it has
// the lock.
//
// Each process measures time with its own clock; clocks of different machines are never compared.
// The holder of a 60 s lease (k_lease_s) renews it every 3 s by writing its file. The holder may
// act for 45 s (k_lease_held_share) from the start of its last successful renewal. An observer
// waits until it has seen the same bytes for 60 s by its own clock.
//
//   take:    list; read the newest file twice, a lease apart, unless its holder is gone;
//            create `lease.N+1` with my text (failure: another process was faster);
//            list: is mine the newest? (no: my first list was out of date; withdraw)
//   renew:   begin := now; write my file; if now < end of my lease: its end := begin + 45 s
//            list: is mine the newest?
//   may act: now < end of my lease, and it was never lost
//
// Invariants
//   1. No two holders may act at the same moment. Suppose that a holder's last renewal began at s
//      and was readable before an observer's first read at t >= s. A later renewal would count only
//      if it was readable before s + 45 s. The observer's last read is after t + 60 s, so the
//      observer would have seen the renewal. So the holder stopped at s + 45 s. The remaining 15 s
//      allow for clocks that run at different rates.
//   2. An expired lease is never renewed: its holder stops permanently.
//   3. The newest file is never removed, so generations only grow. Older files are removed.
//   4. Processes of one machine can see whether the others are running. So a dead holder is noticed
//      at once. A live holder keeps the lock even after its lease has expired.
// The disk must guarantee two things. If a read begins after a write has ended, the read sees the
// write (NFS: close to open). After a machine changes a folder, its own list of the folder is up to
// date.
//
// This code accesses disk and time only through LeaseFiles and the clock. Thread safety: `may_act`
// may be called from any thread, and all other functions from one thread at a time.
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
/// After a renewal, the holder may act for this share of the lease.
inline constexpr double k_lease_held_share = 0.75;
/// Share of the lease after which it is renewed.
inline constexpr double k_renew_share = 0.05;
/// A file with a longer lease is refused.
inline constexpr double k_lease_s_max = 600;

/// Identifies a process that holds or requests a lock.
struct LeaseHolder {
  std::string host{};         ///< host name: for people, and part of `machine`
  std::string machine{};      ///< identifies boot and process-number space; "": unknown
  std::int64_t process = 0;   ///< process id on that machine
  std::uint64_t started = 0;  ///< start in clock ticks, because process ids are reused
  std::string since{};        ///< wall-clock time of taking the lock, for people
};

struct LeaseText {
  LeaseHolder holder{};
  std::string token{};  ///< unique to this holder
  double lease_s = k_lease_s;
  std::uint64_t epoch = 0;  ///< of the run's session; 0: unknown
  std::uint64_t beat = 0;   ///< number of renewals
  bool is_released = false;
  bool owes_copies = false;  ///< see Lease::owes_copies

  /// Returns k_lease_text_bytes bytes, so that a file is always overwritten as a whole.
  std::string to_text() const;
  /// Returns nothing if `text` is not a lease.
  static std::optional<LeaseText> from_text(const std::string& text);
};
inline constexpr std::size_t k_lease_text_bytes = 1024;

/// The operations by which a lease accesses the disk and the machine. lease_files.h has the real
/// operations; tests replace them. Functions throw base::Error if the disk fails.
class LeaseFiles {
 public:
  /// The file that a lease created, open for writing. If another lease's file has the same name,
  /// this object does not write that file.
  class Own {
   public:
    virtual ~Own() = default;
    /// Replaces the text, and returns once the server has stored it.
    virtual void write(const std::string& text) = 0;
  };

  virtual ~LeaseFiles() = default;
  /// Returns the generations that have a file, ascending.
  virtual std::vector<std::uint64_t> list() = 0;
  /// Returns nothing if the file does not exist.
  virtual std::optional<std::string> read(std::uint64_t generation) = 0;
  /// Creates a generation's file with this text, which no other process uses. Null if the file
  /// already exists.
  virtual std::unique_ptr<Own> make(std::uint64_t generation, const std::string& text) = 0;
  /// Not an error if the file does not exist.
  virtual void remove(std::uint64_t generation) = 0;
  /// Returns true only if the holder ran on this machine and has ended.
  virtual bool is_gone(const LeaseHolder& holder) = 0;
  /// Returns whether the holder is running on this machine.
  virtual bool is_here(const LeaseHolder& holder) = 0;
};

class Lease {
 public:
  /// Borrows `files` and `clock`. `text`: holder, token and lease_s of this lease.
  Lease(LeaseFiles& files, const base::Clock& clock, LeaseText text);

  struct Taken {};
  /// Another process has the lease. That process renewed the lease, or runs on this machine.
  struct Held {
    std::optional<LeaseText> by{};  ///< empty: the file can't be parsed
  };
  /// Undecided: call again later.
  struct Unsure {
    std::optional<LeaseText> by{};
    double left_s = 0;  ///< until the holder counts as dead unless it renews
  };
  using Outcome = std::variant<Taken, Held, Unsure>;
  /// Tries to take the lease. Call this again while the result is Unsure. REQUIRES: not taken yet.
  Outcome try_take();

  /// Returns true if a holder on another machine never released the lock, and its files haven't
  /// been replaced since. Such a holder may still write its open files.
  bool owes_copies() const { return text_.owes_copies; }
  /// Marks the protected files as replaced. The next renewal writes the mark to the lease's file.
  void set_copied() { text_.owes_copies = false; }

  /// Renews the lease, and returns whether the holder may continue. If the disk fails, later calls
  /// try again until the lease ends. REQUIRES: taken.
  bool renew();
  /// Written by the next renewal.
  void set_epoch(std::uint64_t epoch) { text_.epoch = epoch; }
  /// Releases the lease. The next process can then take it at once. No effect if the lease was not
  /// taken or has ended. REQUIRES: everything that the lock protects is finished.
  void release();

  /// Returns whether the protected files may be changed now.
  bool may_act() const;
  /// Returns the lease of the process that took the lock from this one, if it is known.
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

  /// The last content that was read from another process's lease, and the time when this content
  /// was first read.
  struct Seen {
    std::uint64_t generation = 0;
    std::string text{};
    double since_s = 0;
  };
  std::optional<Seen> seen_;
};

}  // namespace sleight::store
