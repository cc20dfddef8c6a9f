# What the coordinator (rank 0) and the workers (all other ranks) of one batch job say to each other.
#
#   worker                         coordinator
#     │──── Hello ────────────────────▶│   once, first: both sides must make the same results of one request
#     │◀─── Assignment 17 ─────────────│   a block of units; at most two a thread are before a worker
#     │◀─── Assignment 21 ─────────────│
#     │──── Delivery 17 ──────────────▶│   in the order in which they are done
#     │◀─── Ping ──────────────────────│   after a long silence
#     │──── Pong [21] ────────────────▶│   what is before it
#     │◀─── Stop ──────────────────────│
#     │──── Stop ─────────────────────▶│   the last one
#
# A delivery is a pure function of the request, which every rank reads itself, and the assignment; so
# an assignment may be given to several workers, lost, or repeated. What a worker keeps between two
# are states, by replica and version: a replica's version is the scan before which the state stands.
# Where the coordinator knows who made a version, that worker gets no bytes; a worker that no longer
# has them answers with a delivery without results, and the coordinator sends them.
#
# Every session of a run has an epoch (the run store counts them). Assignments are numbered within
# it; what carries another epoch than the coordinator's is refused.
#
# Messages travel as one MPI message each (MPI_BYTE, tag k_message_tag), a flat array of words.
# Numbers: a replica's first scan is its start, drawn from the prior, as is every scan at inverse
# temperature 0; every other scan is iterations_per_scan proposals. Doubles travel as they are: bit
# for bit.

@0xd3c1f7a9b2e84561;

using Cxx = import "/capnp/c++.capnp";
$Cxx.namespace("sleight::schema::generated");

struct Message {
  union {
    assignment @0 :Assignment;  # coordinator to worker
    stop @1 :Void;              # coordinator to worker: leave; back, as the last: it leaves
    delivery @2 :Delivery;      # worker to coordinator
    failure @3 :Text;           # worker to coordinator: it can't go on, and why
    hello @4 :Hello;            # worker to coordinator, once, first
    ping @5 :UInt64;            # coordinator to worker: the epoch; a pong is wanted
    pong @6 :Pong;              # worker to coordinator
  }
}

# What must be equal for ranks to work on one run, and what a rank is.
struct Hello {
  resultsVersion @0 :Text;   # of the program; deploy/version says how it is made
  identity @1 :Text;   # the request's identity text, as this rank reads it
  threads @2 :UInt32;  # that compute, at least 1
}

struct Unit {
  chain @0 :UInt32;
  replica @1 :UInt32;
  firstScan @2 :UInt64;
  scans @3 :UInt32;               # at least 1; exactly 1 in a part of a ladder
  lineage @4 :UInt64;             # of the state before
  inverseTemperatures @5 :List(Float64);  # of each scan; a single one holds for all
  proposalScales @6 :List(Float64);       # by proposal kind; empty: 1
  excursion @7 :List(Float64);    # of the tempered transition that ends each scan; empty: none
  starts @8 :Bool;                # with the replica's first scan: there is no state before
  seed @9 :UInt64;                # of all random numbers, with chain, replica and scan
}

# Members are at neighbouring temperatures. They go on from scan to scan and swap among themselves, by
# numbers of their chain and seed, which is one for all; a member whose swap partner is outside stops, as does one that comes to endScan, and all when they
# have made scansMax scans together (each one's first is made in any case).
struct LadderPart {
  levels @0 :UInt32;      # of the whole ladder
  firstLevel @1 :UInt32;  # the first member's
  inverseTemperatures @2 :List(Float64);   # by level of the part
  proposalScales @3 :List(List(Float64));  # by level of the part, by proposal kind
  endScan @4 :UInt64;     # no member begins it
  scansMax @5 :UInt32;
}

struct Member {
  unit @0 :Unit;
  union {
    nothing @1 :Void;  # the unit starts, or the worker holds the state before it
    state @2 :Data;    # in the world's own encoding
  }
}

struct Assignment {
  epoch @0 :UInt64;
  assignment @1 :UInt64;
  members @2 :List(Member);  # at least one; without a part exactly one
  union {
    alone @3 :Void;
    part @4 :LadderPart;
  }
}

struct Delivery {
  epoch @0 :UInt64;
  assignment @1 :UInt64;
  results @2 :List(Result);  # of each member, in order; none: a state is missing
  cache @3 :CacheUse;        # of the worker so far
}

struct Result {
  chain @0 :UInt32;
  replica @1 :UInt32;
  firstScan @2 :UInt64;
  scans @3 :List(Scan);     # in order, at least one
  stateAfter @4 :Data;
  costSeconds @5 :Float64;  # measured: for cutting blocks, never stored
  simulations @6 :UInt64;   # that it took: for people, never stored
  failed @7 :List(FailedSimulation);  # the first few, in order; never stored
}

# A simulation that the simulator could not carry out; simulating the state again fails alike.
struct FailedSimulation {
  scan @0 :UInt64;
  kind @1 :UInt32;  # common/plan/failure.h numbers them
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
  state @7 :Data;             # empty where this scan's state is not archived
  inverseTemperature @8 :Float64;  # at which it was sampled
  failures @9 :List(UInt64);       # simulations of the scan that failed, by kind; empty: none
  overlappingStarts @10 :UInt64;   # simulations of it that could not begin
  methodValues @11 :List(Float64); # what the method asks of a scan besides
}

# What a worker's memory of samples has done, for people.
struct CacheUse {
  hits @0 :UInt64;
  misses @1 :UInt64;
  evictions @2 :UInt64;
  bytes @3 :UInt64;
  bytesMax @4 :UInt64;
}

struct Pong {
  epoch @0 :UInt64;
  assignments @1 :List(UInt64);  # before the worker, which answers between two
}
