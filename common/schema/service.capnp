# What a client asks of Sleight's service. This file is the specification of the calls; common/rpc has
# both sides' transport, and the same as C++ values.
#
#   client                                    service (sleightd)
#     │── connects to the Unix socket ──────────▶│   the kernel says whose process the client is
#     │── Entrance.open() ──────────────────────▶│   over TLS: Entrance.login(token)
#     │◀─ Service ───────────────────────────────│
#     │── Service.submit(key, jobs) ────────────▶│
#     │◀─ [17] ──────────────────────────────────│   when it is durable
#     │── Service.watch([17: event 0]) ─────────▶│   answered when there is something
#     │◀─ events 1, 2, progress ─────────────────│
#     │── Service.watch([17: event 2]) ─────────▶│   says also: those came
#     │◀─ event 3 .. the end, settled ───────────│
#     │── Service.fetch(17, archive) ───────────▶│
#     │◀─ File (name, size, SHA-256) ────────────│
#     │── File.read(0, 1 MB) ───────────────────▶│   as often as it takes, from any offset
#     │◀─ bytes ─────────────────────────────────│
#
# Laws
#   1. Fields and values of enumerations are only ever added; calls are added or retired. A default of
#      a field is the meaning of an older program, which does not know it. Numbers (@n) are never used
#      again.
#   2. A call that is repeated changes nothing more; so a client may repeat one whose answer it lost.
#   3. Every result has a refusal. Where it is there, nothing else of the result counts. An exception
#      of Cap'n Proto is a lost connection, or a call that the other side does not know.
#   4. Only text and values travel, never paths of the client; and no capability of the client's: the
#      service calls nobody.
#
# A message has 4 MiB at most, and 32 levels of pointers. An unknown value of an enumeration is refused
# in a request (an older service can't do it), and told as "unknown" in an answer. Times are seconds
# since 1970 of the service's clock; 0: not yet. Texts are UTF-8.

@0xb1a6f0c2d4e87935;

using Cxx = import "/capnp/c++.capnp";
$Cxx.namespace("sleight::rpc::generated");

# The bootstrap interface: all that a peer has before it is known.
interface Entrance {
  open @0 () -> (refusal :Refusal, service :Service);
  # Of a Unix socket, whose peer is known by its uid. Refused over TCP.

  login @1 (token :Text) -> (refusal :Refusal, service :Service);
  # Over TLS, once a connection: one that shows a wrong token is ended. A token that is revoked or
  # expires ends its connections.
}

interface Service {
  submit @0 (submission :Submission) -> (refusal :Refusal, submitted :Submitted);
  # All jobs of a submission are taken, durably, or none.

  list @1 (ask :ListAsk) -> (refusal :Refusal, page :JobPage);
  status @2 (job :UInt64) -> (refusal :Refusal, job :JobView);

  watch @3 (points :List(WatchPoint)) -> (refusal :Refusal, batches :List(Batch));
  # Answers what the client lacks by its points, as soon as there is something; an empty list after
  # 20 s without any. The next call's points say what came. At most 1,000 points, no job twice.

  logs @4 (ask :LogAsk) -> (refusal :Refusal, piece :LogPiece);

  # Each of these did one kind of what `change` does; no service answers them any more.
  retired5 @5 (); retired6 @6 (); retired7 @7 (); retired8 @8 (); retired9 @9 (); retired10 @10 ();
  retired11 @11 ();

  fetch @12 (ask :FetchAsk) -> (refusal :Refusal, files :List(FileRef), hasMore :Bool);
  # At most 64 files, by name. `hasMore`: ask again with `after` of the last name.

  info @13 () -> (refusal :Refusal, server :ServerView);
  drain @14 () -> (refusal :Refusal);
  # Starts nothing more, and stops what runs in order.
  stop @15 () -> (refusal :Refusal);
  # Ends the service; jobs run on, and the next service takes them over.

  # Tokens are made, shown and revoked over the Unix socket alone: one that is lost makes no others.
  createToken @16 (ask :TokenAsk) -> (refusal :Refusal, token :TokenView);
  listTokens @17 () -> (refusal :Refusal, tokens :List(TokenView));
  # The caller's; all of them for the service's own user.
  revokeToken @18 (id :Text) -> (refusal :Refusal, token :TokenView);

  change @19 (ask :ChangeAsk) -> (refusal :Refusal, touched :List(Touched));
}

# What a session by a token may do. Each includes nothing of the others.
enum Scope {
  unknown @0;
  read @1;     # list, status, watch, logs, fetch, info
  submit @2;
  manage @3;   # change
  operate @4;  # drain and stop, of a user who may
}

# The client draws the token, so that a repeated call makes no second one.
struct TokenAsk {
  token @0 :Text;     # the whole token; the service keeps its hash
  name @1 :Text;      # for people
  forUser @2 :Int64 = -1;  # uid; negative: the caller's own. Another's: of the service's own user alone
  scopes @3 :List(Scope);
  validFor @4 :Float64;    # seconds; 0: for ever
  jobsMax @5 :UInt32;      # of this token's, that have not ended; 0: as its user
  coresMax @6 :UInt32;     # of one of its jobs; 0: as its user
}

struct TokenView {
  id @0 :Text;
  name @1 :Text;
  user @2 :UInt32;
  scopes @3 :List(Scope);
  created @4 :Float64;
  expires @5 :Float64;   # 0: never
  expired @11 :Bool;     # it has been seen to be
  revoked @6 :Float64;   # 0: it is not
  lastUsed @7 :Float64;  # 0: never
  lastFrom @8 :Text;     # the address that it was last used from
  jobsMax @9 :UInt32;
  coresMax @10 :UInt32;
}

interface File {
  read @0 (offset :UInt64, bytes :UInt32) -> (refusal :Refusal, piece :Data);
  # All of them; they lie within the file's size, and are 1 MiB at most.
}

struct Refusal {
  kind @0 :Kind;
  sentence @1 :Text;   # what is the matter, for people
  whatToDo @2 :Text;   # may be empty
  diagnostics @3 :List(Diagnostic);  # of a submission's texts

  enum Kind {
    unknown @0;
    notFound @1;     # no such job, group, recording or call
    notAllowed @2;   # another user's
    badRequest @3;
    conflict @4;     # not in this state; the key belongs to another submission
    limit @5;        # too many, too large
    busy @6;         # now; the same call may succeed later
    gone @7;         # was there and is deleted
    environment @8;  # the disk is full, the backend is away
    bug @9;          # the service failed; its log has more
  }
}

# As `sleight check` prints it: file:line:column: message.
struct Diagnostic {
  file @0 :Text;     # the request's name
  line @1 :UInt32;   # from 1
  column @2 :UInt32; # from 1, in characters
  message @3 :Text;
}

struct Submission {
  key @0 :Text;    # drawn by the client, at most 64 bytes; one that is known answers as it did then
  jobs @1 :List(JobAsk);  # 1 to 1,000
  isGroup @2 :Bool;       # several always are
}

struct JobAsk {
  name @0 :Text;     # empty: the request's world
  request @1 :Text;  # TOML, overrides applied; at most 1 MiB, and 3 MiB in a submission
  cores @2 :UInt32;  # a wish; 0: what is free
  ranks @3 :UInt32;  # of mpirun; 0: one process without MPI
  memoryBytes @4 :UInt64;  # of the caches of all processes; 0: the default
  priority @5 :Int32;      # among one user's jobs: higher ones first
  strict @6 :Bool;         # a failed simulation ends the job
  options @7 :List(Option);  # for the system that runs it, as Slurm's partition; 32 at most
}

struct Option {
  name @0 :Text;
  value @1 :Text;
}

struct Submitted {
  jobs @0 :List(UInt64);  # in the submission's order
  group @1 :UInt64;       # 0: none
  wasKnown @2 :Bool;      # by its key: nothing new was submitted
}

# A job, or all jobs of a group.
struct Target {
  union {
    job @0 :UInt64;
    group @1 :UInt64;
  }
}

enum JobState {
  unknown @0;
  queued @1;
  starting @2;
  running @3;
  yielding @4;   # stops in order, since others wait
  held @5;       # goes on by itself where its reason says so, or by `resume`
  done @6;
  failed @7;
  cancelled @8;
}

# A job's changes are numbered from 1 without a gap, and durable before anybody is told.
struct StateChange {
  number @0 :UInt64;
  time @1 :Float64;
  state @2 :JobState;
  reason @3 :Text;
  attempt @4 :UInt64;  # the newest start's number by then; 0: none
}

struct JobView {
  id @0 :UInt64;
  group @1 :UInt64;       # 0: none
  user @2 :UInt32;        # uid
  name @3 :Text;
  world @4 :Text;
  state @5 :JobState;
  reason @6 :Text;        # of the state
  place @7 :UInt64;       # in the queue, from 1; 0: it is not in it
  notYet @8 :Text;        # why it does not run yet
  attempt @9 :UInt64;     # the newest start's number; 0: none
  priority @10 :Int32;
  coresWanted @11 :UInt32;  # 0: what is free
  cores @12 :UInt32;        # that it has now
  ranks @13 :UInt32;
  memoryBytes @14 :UInt64;
  strict @15 :Bool;
  pinned @16 :Bool;

  scansDone @17 :UInt64;   # committed
  scansTotal @18 :UInt64;  # 0: the stop rule can't tell
  found @19 :UInt64;       # solutions that a search built
  foundWanted @20 :UInt64;
  inProportion @21 :UInt64;  # independent solutions of chains
  inProportionWanted @22 :UInt64;
  failures @23 :List(FailureCount);
  simulationsPerSecond @24 :Float64;
  left @25 :Float64 = -1;           # seconds, by scans; negative: not known
  solutionsLeft @26 :Float64 = -1;  # seconds, by solutions; likewise

  coreSeconds @27 :Float64;  # of all attempts
  submitted @28 :Float64;
  started @29 :Float64;
  ended @30 :Float64;
  bytes @31 :UInt64;         # of its folder
  deletedAt @32 :Float64;    # announced; 0: not announced
  digest @33 :Text;          # of the newest archive's content
  resultsVersion @34 :Text;
  endWords @35 :Text;
  lastLogLines @36 :List(Text);  # of a failed job
  repeatCommand @37 :Text;       # of a failed job
  history @38 :List(StateChange);  # of `status` alone; the newest 1,000, oldest first
}

struct FailureCount {
  simulation @0 :Text;  # the kind's name
  count @1 :UInt64;
}

# All that is given must hold.
struct ListAsk {
  group @0 :UInt64;        # 0: any
  user @1 :Int64 = -1;     # uid; negative: all that the caller may see
  states @2 :List(JobState);  # empty: any
  namePart @3 :Text;
  oldestFirst @4 :Bool;
  count @5 :UInt32;        # 500 at most
  cursor @6 :Text;         # of the page before; empty: the first page
}

struct JobPage {
  jobs @0 :List(JobView);
  cursor @1 :Text;         # empty: this is the last page
  total @2 :UInt64;        # that match
}

# A change of a job, or of each job of a group.
struct ChangeAsk {
  target @0 :Target;
  kind @1 :Kind;
  extension @2 :Extension;  # of extend
  priority @3 :Int32;       # of setPriority

  enum Kind {
    unknown @0;
    cancel @1;       # stops in order and ends the job, with the archive of what it has
    hold @2;         # stops in order; `resume` goes on
    resume @3;       # queues a held, failed or cancelled job again
    extend @4;       # a longer [stop]; the job is queued again if it had ended
    erase @5;        # deletes settled jobs and all that they have
    pin @6;          # a pinned job is kept whatever the rule for finished jobs says
    unpin @7;
    setPriority @8;
  }
}

struct Touched {
  job @0 :UInt64;
  state @1 :JobState;  # after the call
  words @2 :Text;
}

struct Extension {
  by @0 :By;
  to @1 :Float64;  # absolute; of odds the relative error

  enum By {
    unknown @0;
    scans @1;
    rounds @2;
    solutions @3;
    odds @4;
  }
}

# How much of a job a watcher has.
struct WatchPoint {
  job @0 :UInt64;
  event @1 :UInt64;   # number of the last numbered event
  change @2 :UInt64;  # number of the last state change
  mark @3 :UInt64;    # of the batch before; 0: none. The service's own, of what is unnumbered
}

# What a watcher lacks of a job.
struct Batch {
  job @0 :UInt64;
  refusal @1 :Refusal;  # this job can't be watched (any more)
  changes @2 :List(StateChange);  # consecutive
  events @3 :List(Event);  # numbered ones consecutive; of the others only the newest
  mark @4 :UInt64;
  settled @5 :Bool;  # ended, and nothing numbered is left to tell
}

struct Event {
  number @0 :UInt64;  # 0: unnumbered
  line @1 :Text;      # JSON, as common/events/run_event.h says; without a newline
}

struct LogAsk {
  job @0 :UInt64;
  isTail @1 :Bool;    # the last lines; else from an offset on
  from @2 :UInt64;    # of all bytes ever logged
  lines @3 :UInt32;
  bytesMax @4 :UInt32;  # 512 KiB at most
}

struct LogPiece {
  first @0 :UInt64;   # offset of the first byte: greater than `from` where that is lost
  bytes @1 :Data;     # of any encoding: programs write them
  end @2 :UInt64;     # of the log as it is now
  isOver @3 :Bool;    # nothing will come after `end`
}

struct FetchAsk {
  job @0 :UInt64;
  kind @1 :Kind;
  ids @2 :List(UInt64);   # of recordings; at most 10,000
  after @3 :Text;         # only files that come after this name
  sha256Wanted @4 :Text;  # of the file that the client has a part of

  enum Kind {
    unknown @0;
    archive @1;       # the newest
    soFar @2;         # one made now
    recordings @3;    # of kept animations
    failureFiles @4;
  }
}

struct FileRef {
  name @0 :Text;    # a plain file name
  size @1 :UInt64;
  sha256 @2 :Text;  # of its bytes, hexadecimal
  file @3 :File;
}

struct ServerView {
  version @0 :Text;
  resultsVersion @1 :Text;
  stateFolder @2 :Text;
  pid @3 :Int64;
  up @4 :Float64;  # seconds
  draining @5 :Bool;
  backend @6 :Text;
  cores @7 :UInt32;
  coresUsed @8 :UInt32;
  memoryBytes @9 :UInt64;
  memoryUsedBytes @10 :UInt64;
  diskFreeBytes @11 :UInt64;
  diskReserveBytes @12 :UInt64;
  keepingRule @13 :Text;
  limits @14 :List(NamedLimit);
  counts @15 :List(StateCount);
  connections @16 :UInt32;
  watchers @17 :UInt32;
  address @18 :Text;      # where it listens over TCP; empty: nowhere
  fingerprint @19 :Text;  # of its certificate there
}

struct NamedLimit {
  name @0 :Text;
  value @1 :Text;
}

struct StateCount {
  state @0 :JobState;
  count @1 :UInt64;
}
