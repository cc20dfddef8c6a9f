# The messages between the coordinator (rank 0) and the workers (all other ranks) of one batch job.
#
#   worker                         coordinator
#     │──── Hello ────────────────────▶│   first and once: both must derive equal results from a request
#     │◀─── Assignment 17 ─────────────│   a block of units; at most two per thread are outstanding
#     │◀─── Assignment 21 ─────────────│
#     │──── Delivery 17 ──────────────▶│   in order of completion
#     │◀─── Ping ──────────────────────│   after a long silence
#     │──── Pong [21] ────────────────▶│   the worker's outstanding assignments
#     │◀─── Stop ──────────────────────│
#     │──── Stop ─────────────────────▶│   last message
#
# A delivery is a pure function of the assignment and the request, which every rank reads itself. So
# an assignment may be given to several workers, lost, or repeated. Between assignments a worker
# stores only states, by replica and version; the version is the number of the scan that follows the
# state. If the coordinator knows that a worker made a version, it sends that worker no bytes. A
# worker that has dropped the state answers with a delivery without results, and the coordinator
# then sends the bytes.
#
# Each session of a run has an epoch, counted by the run store. Assignments are numbered within
# their epoch. The coordinator refuses messages with another epoch.
#
# Each message is one MPI message (MPI_BYTE, tag k_message_tag), a flat array of words. A replica's
# first scan is its start, drawn from the prior, as is every scan at inverse temperature 0. Every
# other scan is iterations_per_scan proposals. Doubles are sent bit for bit.

@0xd3c1f7a9b2e84561;

using Cxx = import "/capnp/c++.capnp";
$Cxx.namespace("sleight::schema::generated");

struct Message {
  union {
    assignment @0 :Assignment;  # coordinator to worker
    stop @1 :Void;              # coordinator to worker: leave; worker to coordinator: last message
    delivery @2 :Delivery;      # worker to coordinator
    failure @3 :Text;           # worker to coordinator: why it can't continue
    hello @4 :Hello;            # worker to coordinator, once, first
    ping @5 :UInt64;            # coordinator to worker: the epoch; expects a pong
    pong @6 :Pong;              # worker to coordinator
  }
}

# Versions and texts that must be equal on all ranks of a run, and this rank's threads.
struct Hello {
  resultsVersion @0 :Text;   # of the program; see deploy/version
  identity @1 :Text;   # the request's identity text as read by this rank
  threads @2 :UInt32;  # computing threads, at least 1
}

struct Unit {
  chain @0 :UInt32;
  replica @1 :UInt32;
  firstScan @2 :UInt64;
  scans @3 :UInt32;               # at least 1; exactly 1 in a part of a ladder
  lineage @4 :UInt64;             # of the previous state
  inverseTemperatures @5 :List(Float64);  # one per scan, or a single one for all
  proposalScales @6 :List(Float64);       # by proposal kind; empty: 1
  excursion @7 :List(Float64);    # of the tempered transition at the end of each scan; empty: none
  starts @8 :Bool;                # the unit begins with the replica's first scan, without a previous state
  seed @9 :UInt64;                # of all random numbers, together with chain, replica and scan
}

# Members are at neighbouring temperatures and share chain and seed, which key the random numbers of
# their swaps. The members advance scan by scan and swap with each other. A member stops if its swap
# partner is outside the part, or at endScan. All members stop after scansMax scans together; each
# member's first scan is always made.
struct LadderPart {
  levels @0 :UInt32;      # of the whole ladder
  firstLevel @1 :UInt32;  # the first member's
  inverseTemperatures @2 :List(Float64);   # by level of the part
  proposalScales @3 :List(List(Float64));  # by level of the part, by proposal kind
  endScan @4 :UInt64;     # the first scan that is not made
  scansMax @5 :UInt32;
}

struct Member {
  unit @0 :Unit;
  union {
    nothing @1 :Void;  # the unit starts, or the worker has the previous state
    state @2 :Data;    # in the world's own encoding
  }
}

struct Assignment {
  epoch @0 :UInt64;
  assignment @1 :UInt64;
  members @2 :List(Member);  # at least one; exactly one without a part
  union {
    alone @3 :Void;
    part @4 :LadderPart;
  }
}

struct Delivery {
  epoch @0 :UInt64;
  assignment @1 :UInt64;
  results @2 :List(Result);  # one per member, in order; empty: a state is missing
  cache @3 :CacheUse;        # of the worker so far
}

struct Result {
  chain @0 :UInt32;
  replica @1 :UInt32;
  firstScan @2 :UInt64;
  scans @3 :List(Scan);     # in order, at least one
  stateAfter @4 :Data;
  costSeconds @5 :Float64;  # measured, for cutting blocks; never stored
  simulations @6 :UInt64;   # number made, for display; never stored
  failed @7 :List(FailedSimulation);  # the first few, in order; never stored
}

# A simulation that the simulator couldn't complete. Simulating the state again fails in the same
# way.
struct FailedSimulation {
  scan @0 :UInt64;
  kind @1 :UInt32;  # numbered in common/plan/failure.h
  message @2 :Text;
  state @3 :Data;   # in the world's own encoding
}

struct Scan {
  logPrior @0 :Float64;
  logConstraint @1 :Float64;
  satisfied @2 :Bool;
  lineage @3 :UInt64;
  proposed @4 :List(UInt32);  # by proposal kind
  accepted @5 :List(UInt32);
  outcome @6 :List(Float64);  # the world's outcome scalars
  state @7 :Data;             # empty if this scan's state is not archived
  inverseTemperature @8 :Float64;  # of the sampling
  failures @9 :List(UInt64);       # failed simulations of the scan, by kind; empty: none
  overlappingStarts @10 :UInt64;   # simulations of the scan that couldn't begin
  methodValues @11 :List(Float64); # additional values required by the method
}

# Statistics of a worker's sample cache, for display.
struct CacheUse {
  hits @0 :UInt64;
  misses @1 :UInt64;
  evictions @2 :UInt64;
  bytes @3 :UInt64;
  bytesMax @4 :UInt64;
}

struct Pong {
  epoch @0 :UInt64;
  assignments @1 :List(UInt64);  # outstanding; the worker replies between two assignments
}
