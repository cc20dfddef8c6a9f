# What the coordinator (rank 0) and the workers (all other ranks) of one batch job say to each other.
#
# A worker is idle until it gets an Assignment; it answers each with one Result or Failure, in
# order. It keeps nothing between two assignments that could change a result: everything that a
# unit's result depends on is the request, which every rank reads itself, and the assignment.
# Messages travel as one MPI message each (MPI_BYTE, tag k_message_tag), a flat array of words.
#
# Numbers: a replica's first scan is its start, drawn from the prior, as is every scan at inverse
# temperature 0; every other scan is iterations_per_scan proposals. Doubles travel as they are: bit for bit.

@0xd3c1f7a9b2e84561;

using Cxx = import "/capnp/c++.capnp";
$Cxx.namespace("sleight::schema::wire");

struct Message {
  union {
    assignment @0 :Assignment;  # coordinator to worker
    stop @1 :Void;              # coordinator to worker: leave; no answer
    result @2 :Result;          # worker to coordinator
    failure @3 :Text;           # worker to coordinator: it can't go on, and why
    hello @4 :Hello;            # worker to coordinator, once, first
  }
}

# What must be equal for ranks to work on one run.
struct Hello {
  programVersion @0 :Text;
  identity @1 :Text;   # the request's identity text, as this rank reads it
}

struct Unit {
  chain @0 :UInt32;
  replica @1 :UInt32;
  firstScan @2 :UInt64;
  scans @3 :UInt32;               # at least 1
  lineage @4 :UInt64;             # of the state before
  inverseTemperatures @5 :List(Float64);  # of each scan; a single one holds for all
  proposalScales @6 :List(Float64);       # by proposal kind; empty: 1
  excursion @7 :List(Float64);    # of the tempered transition that ends each scan; empty: none
  starts @8 :Bool;                # with the replica's first scan: there is no state before
}

struct Assignment {
  unit @0 :Unit;
  state @1 :Data;  # the replica's state before firstScan, in the world's own encoding; empty for the replica's first scan
}

struct Result {
  unit @0 :Unit;       # as assigned
  scans @1 :List(Scan);  # unit.scans of them, in order
  stateAfter @2 :Data;
  costSeconds @3 :Float64;  # measured: for cutting units, never stored
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
}
