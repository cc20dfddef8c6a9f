# The calls that clients make to Sleight's service. This file is the specification; common/rpc has
# both sides' transport, and the same types as C++ values.
#
#   client                                    service (sleightd)
#     │── connects to the Unix socket ──────────▶│   the kernel reports the client's uid
#     │── Entrance.open() ──────────────────────▶│   over TLS: Entrance.login(token)
#     │◀─ Service ───────────────────────────────│
#     │── Service.submit(key, jobs) ────────────▶│
#     │◀─ [17] ──────────────────────────────────│   once the jobs are durable
#     │── Service.watch([17: event 0]) ─────────▶│   answered as soon as there is news
#     │◀─ events 1, 2, progress ─────────────────│
#     │── Service.watch([17: event 2]) ─────────▶│   acknowledges events 1 and 2
#     │◀─ event 3 .. last event, settled ────────│
#     │── Service.fetch(17, archive) ───────────▶│
#     │◀─ File (name, size, SHA-256) ────────────│
#     │── File.read(0, 1 MB) ───────────────────▶│   repeated as needed, from any offset
#     │◀─ bytes ─────────────────────────────────│
#
# Laws
#   1. Fields and enumeration values are only added; calls are added or retired. A field's default
#      is the meaning of older programs, which lack the field. Numbers (@n) are never reused.
#   2. Repeating a call changes nothing more, so a client may repeat a call whose answer was lost.
#   3. Every result has a refusal. If the refusal is set, nothing else in the result counts. A Cap'n
#      Proto exception means a lost connection, or a call that the other side does not support.
#   4. Only text and values are sent, never paths on the client's machine. Clients send no
#      capabilities, because the service never calls a client.
#
# A message has at most 4 MiB and 32 levels of pointers. A request with an unknown enumeration value
# is refused; an answer reports unknown values as "unknown". Times are seconds since 1970 of the
# service's clock; 0: not yet. Texts are UTF-8.

@0xb1a6f0c2d4e87935;

using Cxx = import "/capnp/c++.capnp";
$Cxx.namespace("sleight::rpc::generated");

# The bootstrap interface: all that a peer can call before it is identified.
interface Entrance {
  open @0 () -> (refusal :Refusal, service :Service);
  # For a Unix socket, whose peer is identified by its uid. Refused over TCP.

  login @1 (token :Text) -> (refusal :Refusal, service :Service);
  # For TLS, once per connection. A wrong token ends the connection. Revoking a token, or its
  # expiry, ends its connections.
}

interface Service {
  submit @0 (submission :Submission) -> (refusal :Refusal, submitted :Submitted);
  # Accepts all jobs of a submission durably, or none.

  list @1 (ask :ListAsk) -> (refusal :Refusal, page :JobPage);
  status @2 (job :UInt64) -> (refusal :Refusal, job :JobView);

  watch @3 (points :List(WatchPoint)) -> (refusal :Refusal, batches :List(Batch));
  # Answers with the news that the client lacks according to its points, as soon as there is any, or
  # with an empty list after 20 s. The next call's points acknowledge what arrived. At most 1,000
  # points, no job twice.

  logs @4 (ask :LogAsk) -> (refusal :Refusal, piece :LogPiece);

  # Retired calls, each now a kind of `change`. No service answers them any more.
  retired5 @5 (); retired6 @6 (); retired7 @7 (); retired8 @8 (); retired9 @9 (); retired10 @10 ();
  retired11 @11 ();

  fetch @12 (ask :FetchAsk) -> (refusal :Refusal, files :List(FileRef), hasMore :Bool);
  # Answers at most 64 files, sorted by name. If `hasMore`, repeat with `after` = the last name.

  info @13 () -> (refusal :Refusal, server :ServerView);
  drain @14 () -> (refusal :Refusal);
  # Starts no more jobs and stops running jobs cleanly.
  stop @15 () -> (refusal :Refusal);
  # Ends the service. Jobs keep running, and the next service takes them over.

  # Tokens are created, listed and revoked only over the Unix socket, so a stolen token can't create
  # others.
  createToken @16 (ask :TokenAsk) -> (refusal :Refusal, token :TokenView);
  listTokens @17 () -> (refusal :Refusal, tokens :List(TokenView));
  # The caller's tokens, or all tokens for the service's own user.
  revokeToken @18 (id :Text) -> (refusal :Refusal, token :TokenView);

  change @19 (ask :ChangeAsk) -> (refusal :Refusal, touched :List(Touched));
}

# Permissions of a token's session. No scope includes another.
enum Scope {
  unknown @0;
  read @1;     # list, status, watch, logs, fetch, info
  submit @2;
  manage @3;   # change
  operate @4;  # drain and stop, if the user may
}

# The client draws the token, so that a repeated call creates no second token.
struct TokenAsk {
  token @0 :Text;     # complete token; the service stores its hash
  name @1 :Text;      # for people
  forUser @2 :Int64 = -1;  # uid; negative: the caller's. Only the service's own user may set it
  scopes @3 :List(Scope);
  validFor @4 :Float64;    # seconds; 0: no expiry
  jobsMax @5 :UInt32;      # unfinished jobs of this token; 0: the user's limit
  coresMax @6 :UInt32;     # per job of this token; 0: the user's limit
}

struct TokenView {
  id @0 :Text;
  name @1 :Text;
  user @2 :UInt32;
  scopes @3 :List(Scope);
  created @4 :Float64;
  expires @5 :Float64;   # 0: never
  expired @11 :Bool;     # expiry was seen
  revoked @6 :Float64;   # 0: not revoked
  lastUsed @7 :Float64;  # 0: never
  lastFrom @8 :Text;     # address of the last use
  jobsMax @9 :UInt32;
  coresMax @10 :UInt32;
}

interface File {
  read @0 (offset :UInt64, bytes :UInt32) -> (refusal :Refusal, piece :Data);
  # Returns all requested bytes, which must lie within the file and be at most 1 MiB.
}

struct Refusal {
  kind @0 :Kind;
  sentence @1 :Text;   # what is wrong, for people
  whatToDo @2 :Text;   # may be empty
  diagnostics @3 :List(Diagnostic);  # for a submission's texts

  enum Kind {
    unknown @0;
    notFound @1;     # no such job, group, recording or call
    notAllowed @2;   # belongs to another user
    badRequest @3;
    conflict @4;     # wrong state, or the key of another submission
    limit @5;        # too many or too large
    busy @6;         # temporary: the same call may succeed later
    gone @7;         # existed and was deleted
    environment @8;  # the disk is full, the backend is away
    bug @9;          # the service failed; see its log
  }
}

# Printed by `sleight check` as file:line:column: message.
struct Diagnostic {
  file @0 :Text;     # the request's name
  line @1 :UInt32;   # from 1
  column @2 :UInt32; # from 1, in characters
  message @3 :Text;
}

struct Submission {
  key @0 :Text;    # drawn by the client, at most 64 bytes; a known key returns the first answer
  jobs @1 :List(JobAsk);  # 1 to 1,000
  isGroup @2 :Bool;       # always true for several jobs
}

struct JobAsk {
  name @0 :Text;     # empty: the request's world
  request @1 :Text;  # TOML, overrides applied; at most 1 MiB, and 3 MiB in a submission
  cores @2 :UInt32;  # requested number; 0: all free cores
  ranks @3 :UInt32;  # MPI ranks; 0: one process without MPI
  memoryBytes @4 :UInt64;  # for the caches of all processes; 0: the default
  priority @5 :Int32;      # among one user's jobs; higher runs first
  strict @6 :Bool;         # a failed simulation ends the job
  options @7 :List(Option);  # for the backend, such as Slurm's partition; at most 32
}

struct Option {
  name @0 :Text;
  value @1 :Text;
}

struct Submitted {
  jobs @0 :List(UInt64);  # in the submission's order
  group @1 :UInt64;       # 0: none
  wasKnown @2 :Bool;      # the key was used before: nothing new was submitted
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
  yielding @4;   # stops cleanly because other jobs wait
  held @5;       # continues by `resume`, or automatically if the reason says so
  done @6;
  failed @7;
  cancelled @8;
}

# A job's changes are numbered from 1 without gaps, and are durable before they are reported.
struct StateChange {
  number @0 :UInt64;
  time @1 :Float64;
  state @2 :JobState;
  reason @3 :Text;
  attempt @4 :UInt64;  # number of the newest start so far; 0: none
}

struct JobView {
  id @0 :UInt64;
  group @1 :UInt64;       # 0: none
  user @2 :UInt32;        # uid
  name @3 :Text;
  world @4 :Text;
  state @5 :JobState;
  reason @6 :Text;        # why the job is in this state
  place @7 :UInt64;       # in the queue, from 1; 0: not queued
  notYet @8 :Text;        # why the job does not run yet
  attempt @9 :UInt64;     # number of the newest start; 0: none
  priority @10 :Int32;
  coresWanted @11 :UInt32;  # 0: all free cores
  cores @12 :UInt32;        # in use now
  ranks @13 :UInt32;
  memoryBytes @14 :UInt64;
  strict @15 :Bool;
  pinned @16 :Bool;

  scansDone @17 :UInt64;   # committed
  scansTotal @18 :UInt64;  # 0: unknown from the stop rule
  found @19 :UInt64;       # solutions that a search built
  foundWanted @20 :UInt64;
  inProportion @21 :UInt64;  # independent solutions of chains
  inProportionWanted @22 :UInt64;
  failures @23 :List(FailureCount);
  simulationsPerSecond @24 :Float64;
  left @25 :Float64 = -1;           # seconds until the end, by scans; negative: unknown
  solutionsLeft @26 :Float64 = -1;  # seconds until enough solutions; negative: unknown

  coreSeconds @27 :Float64;  # of all attempts
  submitted @28 :Float64;
  started @29 :Float64;
  ended @30 :Float64;
  bytes @31 :UInt64;         # size of the job's folder
  deletedAt @32 :Float64;    # announced deletion; 0: not announced
  digest @33 :Text;          # of the newest archive's content
  resultsVersion @34 :Text;
  endWords @35 :Text;
  lastLogLines @36 :List(Text);  # of a failed job
  repeatCommand @37 :Text;       # of a failed job
  history @38 :List(StateChange);  # only in `status`; the newest 1,000, oldest first
}

struct FailureCount {
  simulation @0 :Text;  # the failure kind's name
  count @1 :UInt64;
}

# Selects jobs that meet all given conditions.
struct ListAsk {
  group @0 :UInt64;        # 0: any
  user @1 :Int64 = -1;     # uid; negative: all that the caller may see
  states @2 :List(JobState);  # empty: any
  namePart @3 :Text;
  oldestFirst @4 :Bool;
  count @5 :UInt32;        # at most 500
  cursor @6 :Text;         # from the page before; empty: first page
}

struct JobPage {
  jobs @0 :List(JobView);
  cursor @1 :Text;         # empty: last page
  total @2 :UInt64;        # number of matching jobs
}

# Changes a job, or each job of a group.
struct ChangeAsk {
  target @0 :Target;
  kind @1 :Kind;
  extension @2 :Extension;  # for extend
  priority @3 :Int32;       # for setPriority

  enum Kind {
    unknown @0;
    cancel @1;       # stops cleanly and ends the job, with an archive of its results so far
    hold @2;         # stops cleanly, until `resume`
    resume @3;       # queues a held, failed or cancelled job again
    extend @4;       # raises [stop]; queues an ended job again
    erase @5;        # deletes ended jobs and all their data
    pin @6;          # exempts the job from the deletion of finished jobs
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
  to @1 :Float64;  # absolute; for odds the relative error

  enum By {
    unknown @0;
    scans @1;
    rounds @2;
    solutions @3;
    odds @4;
  }
}

# The events of a job that a watcher already has.
struct WatchPoint {
  job @0 :UInt64;
  event @1 :UInt64;   # number of the last numbered event
  change @2 :UInt64;  # number of the last state change
  mark @3 :UInt64;    # from the previous batch, the service's marker for unnumbered events; 0: none
}

# The news that a watcher of a job lacks.
struct Batch {
  job @0 :UInt64;
  refusal @1 :Refusal;  # set if this job can't be watched
  changes @2 :List(StateChange);  # consecutive
  events @3 :List(Event);  # numbered ones consecutive, and only the newest unnumbered ones
  mark @4 :UInt64;
  settled @5 :Bool;  # ended, and all numbered events are delivered
}

struct Event {
  number @0 :UInt64;  # 0: unnumbered
  line @1 :Text;      # JSON, see common/events/run_event.h; without a newline
}

struct LogAsk {
  job @0 :UInt64;
  isTail @1 :Bool;    # the last lines; else from an offset
  from @2 :UInt64;    # offset in all bytes ever logged
  lines @3 :UInt32;
  bytesMax @4 :UInt32;  # at most 512 KiB
}

struct LogPiece {
  first @0 :UInt64;   # offset of the first byte; greater than `from` if older bytes are lost
  bytes @1 :Data;     # any encoding, as programs write it
  end @2 :UInt64;     # current end of the log
  isOver @3 :Bool;    # nothing will follow `end`
}

struct FetchAsk {
  job @0 :UInt64;
  kind @1 :Kind;
  ids @2 :List(UInt64);   # of recordings; at most 10,000
  after @3 :Text;         # only files after this name
  sha256Wanted @4 :Text;  # of a partly received file

  enum Kind {
    unknown @0;
    archive @1;       # newest archive
    soFar @2;         # archive made now
    recordings @3;    # of kept animations
    failureFiles @4;
  }
}

struct FileRef {
  name @0 :Text;    # a plain file name
  size @1 :UInt64;
  sha256 @2 :Text;  # of the content, hexadecimal
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
  address @18 :Text;      # TCP address; empty: not listening
  fingerprint @19 :Text;  # of the TLS certificate
}

struct NamedLimit {
  name @0 :Text;
  value @1 :Text;
}

struct StateCount {
  state @0 :JobState;
  count @1 :UInt64;
}
