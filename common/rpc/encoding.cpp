#include "common/rpc/encoding.h"

#include <algorithm>
#include <bit>
#include <concepts>
#include <cstdint>
#include <iterator>
#include <optional>
#include <span>
#include <string_view>
#include <type_traits>

#include "common/base/check.h"

namespace sleight::rpc {
namespace {

constexpr std::size_t k_line_bytes_max = 512;  // per text in a list of jobs
constexpr std::size_t k_no_bound = SIZE_MAX;

/// Number of an enumeration's values that this program knows.
template <class Enum>
constexpr std::size_t k_known = 0;
template <>
constexpr std::size_t k_known<JobState> = k_job_states;
template <>
constexpr std::size_t k_known<RefusalKind> = k_refusal_kinds;
template <>
constexpr std::size_t k_known<ChangeKind> = k_change_kinds;
template <>
constexpr std::size_t k_known<ExtendBy> = 5;
template <>
constexpr std::size_t k_known<FetchKind> = 5;

static_assert(static_cast<int>(generated::JobState::CANCELLED) ==
              static_cast<int>(JobState::cancelled));
static_assert(static_cast<int>(generated::JobState::HELD) == static_cast<int>(JobState::held));
static_assert(static_cast<int>(generated::Refusal::Kind::BUG) ==
              static_cast<int>(RefusalKind::bug));
static_assert(static_cast<int>(generated::Refusal::Kind::BUSY) ==
              static_cast<int>(RefusalKind::busy));
static_assert(static_cast<int>(generated::ChangeAsk::Kind::SET_PRIORITY) ==
              static_cast<int>(ChangeKind::set_priority));
static_assert(static_cast<int>(generated::Extension::By::ODDS) == static_cast<int>(ExtendBy::odds));
static_assert(static_cast<std::size_t>(generated::Scope::OPERATE) == std::size(k_scopes));
static_assert(static_cast<int>(generated::FetchAsk::Kind::FAILURE_FILES) ==
              static_cast<int>(FetchKind::failure_files));

/// Truncates a text to at most `bytes_max` bytes, between two UTF-8 characters.
std::string_view cut(const std::string& text, std::size_t bytes_max) {
  if (text.size() <= bytes_max) return text;
  std::size_t size = bytes_max;
  while (size > 0 && (static_cast<unsigned char>(text[size]) & 0xC0U) == 0x80U)
    --size;
  return {text.data(), size};
}

/// Copies the text if it must be truncated, because a Cap'n Proto text must end with a zero byte.
void put_text(const std::string& text, std::size_t bytes_max, const auto& set) {
  const std::string_view short_text = cut(text, bytes_max);
  if (short_text.size() == text.size()) {
    set(as_text(text));
  } else {
    const std::string copy(short_text);
    set(as_text(copy));
  }
}

// Each struct lists its fields once, in `fields`, for both Writer and Reader. Each field has two
// functions. The first function sets the field in a builder, or initialises a field that is a list
// or struct. The second function gets the field from a reader.

#define SLEIGHT_GET(Name) [](auto from) { return from.get##Name(); }
#define SLEIGHT_SET(Name) [](auto to, auto value) { to.set##Name(value); }
#define SLEIGHT_FIELD(Name, ours) visit.field(SLEIGHT_SET(Name), SLEIGHT_GET(Name), ours)
#define SLEIGHT_TEXT(Name, ours, bytes_max) \
  visit.text(SLEIGHT_SET(Name), SLEIGHT_GET(Name), ours, bytes_max)
#define SLEIGHT_PART(Name, ours) \
  visit.part([](auto to) { return to.init##Name(); }, SLEIGHT_GET(Name), ours)
#define SLEIGHT_LIST(Name, ours, ...)                                                             \
  visit.list([](auto to, unsigned size) { return to.init##Name(size); }, SLEIGHT_GET(Name), ours, \
             Bounds{__VA_ARGS__})

/// Limits of a list. Elements beyond them are omitted.
struct Bounds {
  std::size_t written = k_no_bound;
  /// Maximum elements to read: one more than the limit, so that limits.h refuses longer lists.
  /// Without a maximum, a small message could claim a huge list, because elements without content
  /// need no bytes.
  std::size_t read = k_no_bound;
  std::size_t text_bytes = k_no_bound;  ///< per text
};

template <class T>
concept IsStruct = std::is_class_v<T> && !std::same_as<T, std::string> && !requires {
  typename T::representation;
};

template <class T, class Struct>
concept Is = std::same_as<std::remove_const_t<T>, Struct>;

template <class T>
constexpr bool is_optional = false;
template <class T>
constexpr bool is_optional<std::optional<T>> = true;

template <IsStruct Ours, class To>
void write(const Ours& ours, To to, bool is_brief);
template <IsStruct Ours, class From>
void read(From from, Ours& ours);

void write(const Target& target, generated::Target::Builder to, bool) {
  CHECK_NE(target.job.has_value(), target.group.has_value());
  if (target.job) {
    to.setJob(target.job->value);
  } else {
    to.setGroup(target.group->value);
  }
}

// Reads a target. A newer client may send a kind of target that is unknown here. Such a target is
// read as job 0, which never exists.
void read(generated::Target::Reader from, Target& target) {
  target = from.isGroup() ? Target::of(GroupId{from.getGroup()})
                          : Target::of(JobId{from.isJob() ? from.getJob() : 0});
}

template <class To>
struct Writer {
  To to;
  bool is_brief;  ///< part of a list: omit histories, logs and long texts

  template <class Theirs, class T>
  static auto wire(const T& ours) {
    if constexpr (std::is_enum_v<T>) {
      return static_cast<Theirs>(ours);
    } else if constexpr (std::same_as<Theirs, capnp::Data::Builder>) {
      return as_data(std::as_bytes(std::span(ours)));
    } else if constexpr (std::same_as<T, std::string>) {
      return as_text(ours);
    } else if constexpr (is_optional<T>) {
      // An empty optional is written as 0 for unsigned types, and as -1 for others.
      return ours ? static_cast<Theirs>(wire<Theirs>(*ours))
                  : static_cast<Theirs>(std::unsigned_integral<Theirs> ? 0 : -1);
    } else if constexpr (requires { ours.value; }) {
      return ours.value;
    } else {
      return ours;
    }
  }
  void field(const auto& set, const auto& get, const auto& ours) {
    set(to, wire<decltype(get(to))>(ours));
  }
  void text(const auto& set, const auto&, const std::string& ours, std::size_t bytes_max) {
    put_text(ours, bytes_max, [&](capnp::Text::Reader text) { set(to, text); });
  }
  void part(const auto& init, const auto&, const auto& ours) { write(ours, init(to), is_brief); }
  template <class T>
  void list(const auto& init, const auto&, const std::vector<T>& ours, const Bounds& bounds) {
    const auto size = static_cast<unsigned>(std::min(ours.size(), bounds.written));
    if (size == 0) return;
    auto theirs = init(to, size);
    for (unsigned i = 0; i < size; ++i) {
      if constexpr (IsStruct<T>) {
        write(ours[i], theirs[i], true);
      } else if constexpr (std::same_as<T, std::string>) {
        put_text(ours[i], bounds.text_bytes,
                 [&](capnp::Text::Reader text) { theirs.set(i, text); });
      } else {
        theirs.set(i, wire<std::decay_t<decltype(theirs[i])>>(ours[i]));
      }
    }
  }
  /// The schema numbers scopes from 1, in the order of their bits.
  void list(const auto& init, const auto&, const Scopes& ours, const Bounds&) {
    auto theirs = init(to, static_cast<unsigned>(std::popcount(ours.bits)));
    unsigned place = 0;
    for (unsigned i = 0; i < std::size(k_scopes); ++i)
      if (ours.has(k_scopes[i])) theirs.set(place++, static_cast<generated::Scope>(i + 1));
  }
};

template <class From>
struct Reader {
  From from;
  static constexpr bool is_brief = false;

  template <class T, class Theirs>
  static T value_of(Theirs theirs) {
    if constexpr (std::is_enum_v<T>) {
      const auto index = static_cast<std::size_t>(theirs);
      return index < k_known<T> ? static_cast<T>(index) : T::unknown;
    } else if constexpr (std::same_as<T, std::string>) {
      return {reinterpret_cast<const char*>(theirs.begin()), theirs.size()};
    } else if constexpr (is_optional<T>) {
      using Value = typename T::value_type;
      if (std::unsigned_integral<Theirs> ? theirs == 0 : !(theirs >= 0)) return std::nullopt;
      // A number outside uint32 must not turn into another valid number.
      if constexpr (std::same_as<Value, std::uint32_t>) {
        return static_cast<std::uint32_t>(
            std::min<std::uint64_t>(static_cast<std::uint64_t>(theirs), UINT32_MAX));
      } else {
        return value_of<Value>(theirs);
      }
    } else if constexpr (requires { typename T::representation; }) {
      return T{theirs};
    } else {
      return theirs;
    }
  }
  template <class T>
  void field(const auto&, const auto& get, T& ours) {
    ours = value_of<T>(get(from));
  }
  void text(const auto&, const auto& get, std::string& ours, std::size_t) {
    ours = value_of<std::string>(get(from));
  }
  void part(const auto&, const auto& get, auto& ours) { read(get(from), ours); }
  template <class T>
  void list(const auto&, const auto& get, std::vector<T>& ours, const Bounds& bounds) {
    for (const auto theirs : get(from)) {
      if (ours.size() > bounds.read) break;
      if constexpr (IsStruct<T>) {
        read(theirs, ours.emplace_back());
      } else {
        ours.push_back(value_of<T>(theirs));
      }
    }
  }
  void list(const auto&, const auto& get, Scopes& ours, const Bounds&) {
    for (const generated::Scope scope : get(from)) {
      const auto index =
          static_cast<std::size_t>(scope) - 1;  // `unknown` wraps to an index beyond all
      if (index < std::size(k_scopes)) {
        ours.add(k_scopes[index]);
      } else {
        ours.has_unknown = true;
      }
    }
  }
};

void fields(auto& visit, Is<request::Diagnostic> auto& diagnostic) {
  SLEIGHT_TEXT(File, diagnostic.file, k_line_bytes_max);
  SLEIGHT_FIELD(Line, diagnostic.place.line);
  SLEIGHT_FIELD(Column, diagnostic.place.column);
  SLEIGHT_TEXT(Message, diagnostic.message, 4 * k_line_bytes_max);
}

void fields(auto& visit, Is<Refusal> auto& refusal) {
  SLEIGHT_FIELD(Kind, refusal.kind);
  SLEIGHT_TEXT(Sentence, refusal.sentence, k_text_bytes_max);
  SLEIGHT_TEXT(WhatToDo, refusal.what_to_do, k_text_bytes_max);
  SLEIGHT_LIST(Diagnostics, refusal.diagnostics, .written = 2 * request::k_diagnostics_max);
}

// -------------------------------------------------------------------------------------- submitting

void fields(auto& visit, Is<JobOption> auto& option) {
  SLEIGHT_FIELD(Name, option.name);
  SLEIGHT_FIELD(Value, option.value);
}

void fields(auto& visit, Is<JobAsk> auto& job) {
  SLEIGHT_FIELD(Name, job.name);
  SLEIGHT_FIELD(Request, job.request);
  SLEIGHT_FIELD(Cores, job.cores);
  SLEIGHT_FIELD(Ranks, job.ranks);
  SLEIGHT_FIELD(MemoryBytes, job.memory_bytes);
  SLEIGHT_FIELD(Priority, job.priority);
  SLEIGHT_FIELD(Strict, job.strict);
  SLEIGHT_LIST(Options, job.options, .read = k_options_max);
}

void fields(auto& visit, Is<Submission> auto& submission) {
  SLEIGHT_FIELD(Key, submission.key);
  SLEIGHT_LIST(Jobs, submission.jobs, .read = k_submission_jobs_max);
  SLEIGHT_FIELD(IsGroup, submission.is_group);
}

void fields(auto& visit, Is<Submitted> auto& submitted) {
  SLEIGHT_LIST(Jobs, submitted.jobs);
  SLEIGHT_FIELD(Group, submitted.group);
  SLEIGHT_FIELD(WasKnown, submitted.was_known);
}

// -------------------------------------------------------------------------------------------- jobs

void fields(auto& visit, Is<StateChange> auto& change) {
  SLEIGHT_FIELD(Number, change.number);
  SLEIGHT_FIELD(Time, change.time_s);
  SLEIGHT_FIELD(State, change.state);
  SLEIGHT_TEXT(Reason, change.reason, 4 * k_line_bytes_max);
  SLEIGHT_FIELD(Attempt, change.attempt);
}

void fields(auto& visit, Is<FailureCount> auto& failure) {
  SLEIGHT_TEXT(Simulation, failure.simulation, k_name_bytes_max);
  SLEIGHT_FIELD(Count, failure.count);
}

void fields(auto& visit, Is<JobView> auto& job) {
  const std::size_t bytes_max = visit.is_brief ? k_line_bytes_max : k_text_bytes_max;
  SLEIGHT_FIELD(Id, job.id);
  SLEIGHT_FIELD(Group, job.group);
  SLEIGHT_FIELD(User, job.user);
  SLEIGHT_TEXT(Name, job.name, k_name_bytes_max);
  SLEIGHT_TEXT(World, job.world, k_name_bytes_max);
  SLEIGHT_FIELD(State, job.state);
  SLEIGHT_TEXT(Reason, job.reason, bytes_max);
  SLEIGHT_FIELD(Place, job.place);
  SLEIGHT_TEXT(NotYet, job.not_yet, bytes_max);
  SLEIGHT_FIELD(Attempt, job.attempt);
  SLEIGHT_FIELD(Priority, job.priority);
  SLEIGHT_FIELD(CoresWanted, job.cores_wanted);
  SLEIGHT_FIELD(Cores, job.cores);
  SLEIGHT_FIELD(Ranks, job.ranks);
  SLEIGHT_FIELD(MemoryBytes, job.memory_bytes);
  SLEIGHT_FIELD(Strict, job.strict);
  SLEIGHT_FIELD(Pinned, job.pinned);
  SLEIGHT_FIELD(ScansDone, job.scans_done);
  SLEIGHT_FIELD(ScansTotal, job.scans_total);
  SLEIGHT_FIELD(Found, job.solutions.found);
  SLEIGHT_FIELD(FoundWanted, job.solutions.found_wanted);
  SLEIGHT_FIELD(InProportion, job.solutions.in_proportion);
  SLEIGHT_FIELD(InProportionWanted, job.solutions.in_proportion_wanted);
  SLEIGHT_LIST(Failures, job.failures, .written = 64);
  SLEIGHT_FIELD(SimulationsPerSecond, job.simulations_per_s);
  SLEIGHT_FIELD(Left, job.left_s);
  SLEIGHT_FIELD(SolutionsLeft, job.solutions_left_s);
  SLEIGHT_FIELD(CoreSeconds, job.core_s);
  SLEIGHT_FIELD(Submitted, job.submitted_s);
  SLEIGHT_FIELD(Started, job.started_s);
  SLEIGHT_FIELD(Ended, job.ended_s);
  SLEIGHT_FIELD(Bytes, job.bytes);
  SLEIGHT_FIELD(DeletedAt, job.deleted_at_s);
  SLEIGHT_TEXT(Digest, job.digest, k_name_bytes_max);
  SLEIGHT_TEXT(ResultsVersion, job.results_version, k_name_bytes_max);
  SLEIGHT_TEXT(EndWords, job.end_words, bytes_max);
  if (visit.is_brief) return;
  SLEIGHT_LIST(LastLogLines, job.last_log_lines, .written = k_last_log_lines,
               .text_bytes = 4 * k_line_bytes_max);
  SLEIGHT_TEXT(RepeatCommand, job.repeat_command, k_text_bytes_max);
  SLEIGHT_LIST(History, job.history, .written = k_history_max);
}

void fields(auto& visit, Is<ListAsk> auto& ask) {
  SLEIGHT_FIELD(Group, ask.group);
  SLEIGHT_FIELD(User, ask.user);
  SLEIGHT_LIST(States, ask.states, .read = k_job_states);
  SLEIGHT_FIELD(NamePart, ask.name_part);
  SLEIGHT_FIELD(OldestFirst, ask.oldest_first);
  SLEIGHT_FIELD(Count, ask.count);
  SLEIGHT_FIELD(Cursor, ask.cursor);
}

void fields(auto& visit, Is<JobPage> auto& page) {
  SLEIGHT_LIST(Jobs, page.jobs);
  SLEIGHT_FIELD(Cursor, page.cursor);
  SLEIGHT_FIELD(Total, page.total);
}

void fields(auto& visit, Is<Touched> auto& touched) {
  SLEIGHT_FIELD(Job, touched.job);
  SLEIGHT_FIELD(State, touched.state);
  SLEIGHT_TEXT(Words, touched.words, k_line_bytes_max);
}

void fields(auto& visit, Is<Extension> auto& extension) {
  SLEIGHT_FIELD(By, extension.by);
  SLEIGHT_FIELD(To, extension.to);
}

void fields(auto& visit, Is<ChangeAsk> auto& ask) {
  SLEIGHT_PART(Target, ask.target);
  SLEIGHT_FIELD(Kind, ask.kind);
  SLEIGHT_PART(Extension, ask.extension);
  SLEIGHT_FIELD(Priority, ask.priority);
}

// ------------------------------------------------------------------- watching, logs and fetching

void fields(auto& visit, Is<WatchPoint> auto& point) {
  SLEIGHT_FIELD(Job, point.job);
  SLEIGHT_FIELD(Event, point.event);
  SLEIGHT_FIELD(Change, point.change);
  SLEIGHT_FIELD(Mark, point.mark);
}

void fields(auto& visit, Is<LogPiece> auto& piece) {
  SLEIGHT_FIELD(First, piece.first);
  SLEIGHT_FIELD(Bytes, piece.text);
  SLEIGHT_FIELD(End, piece.end);
  SLEIGHT_FIELD(IsOver, piece.is_over);
}

void fields(auto& visit, Is<FetchAsk> auto& ask) {
  SLEIGHT_FIELD(Job, ask.job);
  SLEIGHT_FIELD(Kind, ask.kind);
  SLEIGHT_LIST(Ids, ask.ids);
  SLEIGHT_FIELD(After, ask.after);
  SLEIGHT_FIELD(Sha256Wanted, ask.sha256_wanted);
}

void fields(auto& visit, Is<FileView> auto& file) {
  SLEIGHT_FIELD(Name, file.name);
  SLEIGHT_FIELD(Size, file.size);
  SLEIGHT_FIELD(Sha256, file.sha256);
}

// ------------------------------------------------------------------------------- server and tokens

void fields(auto& visit, Is<NamedLimit> auto& limit) {
  SLEIGHT_TEXT(Name, limit.name, k_line_bytes_max);
  SLEIGHT_TEXT(Value, limit.value, k_line_bytes_max);
}

void fields(auto& visit, Is<StateCount> auto& count) {
  SLEIGHT_FIELD(State, count.state);
  SLEIGHT_FIELD(Count, count.count);
}

void fields(auto& visit, Is<ServerView> auto& server) {
  SLEIGHT_TEXT(Version, server.version, k_name_bytes_max);
  SLEIGHT_TEXT(ResultsVersion, server.results_version, k_name_bytes_max);
  SLEIGHT_TEXT(StateFolder, server.state_folder, k_text_bytes_max);
  SLEIGHT_FIELD(Pid, server.pid);
  SLEIGHT_FIELD(Up, server.up_s);
  SLEIGHT_FIELD(Draining, server.draining);
  SLEIGHT_TEXT(Backend, server.backend, k_name_bytes_max);
  SLEIGHT_FIELD(Cores, server.cores);
  SLEIGHT_FIELD(CoresUsed, server.cores_used);
  SLEIGHT_FIELD(MemoryBytes, server.memory_bytes);
  SLEIGHT_FIELD(MemoryUsedBytes, server.memory_used_bytes);
  SLEIGHT_FIELD(DiskFreeBytes, server.disk_free_bytes);
  SLEIGHT_FIELD(DiskReserveBytes, server.disk_reserve_bytes);
  SLEIGHT_TEXT(KeepingRule, server.keeping_rule, k_text_bytes_max);
  SLEIGHT_LIST(Limits, server.limits, .written = 64);
  SLEIGHT_LIST(Counts, server.counts, .written = k_job_states);
  SLEIGHT_FIELD(Connections, server.connections);
  SLEIGHT_FIELD(Watchers, server.watchers);
  SLEIGHT_TEXT(Address, server.address, k_line_bytes_max);
  SLEIGHT_TEXT(Fingerprint, server.fingerprint, k_line_bytes_max);
}

// A token's texts need no limit here, because limits.h checks them on creation.
void fields(auto& visit, Is<TokenAsk> auto& ask) {
  SLEIGHT_FIELD(Token, ask.token);
  SLEIGHT_FIELD(Name, ask.name);
  SLEIGHT_FIELD(ForUser, ask.for_user);
  SLEIGHT_LIST(Scopes, ask.scopes);
  SLEIGHT_FIELD(ValidFor, ask.valid_s);
  SLEIGHT_FIELD(JobsMax, ask.jobs_max);
  SLEIGHT_FIELD(CoresMax, ask.cores_max);
}

void fields(auto& visit, Is<TokenView> auto& token) {
  SLEIGHT_FIELD(Id, token.id);
  SLEIGHT_FIELD(Name, token.name);
  SLEIGHT_FIELD(User, token.user);
  SLEIGHT_LIST(Scopes, token.scopes);
  SLEIGHT_FIELD(Created, token.created_s);
  SLEIGHT_FIELD(Expires, token.expires_s);
  SLEIGHT_FIELD(Expired, token.has_expired);
  SLEIGHT_FIELD(Revoked, token.revoked_s);
  SLEIGHT_FIELD(LastUsed, token.last_used_s);
  SLEIGHT_FIELD(LastFrom, token.last_from);
  SLEIGHT_FIELD(JobsMax, token.jobs_max);
  SLEIGHT_FIELD(CoresMax, token.cores_max);
}

template <IsStruct Ours, class To>
void write(const Ours& ours, To to, bool is_brief) {
  Writer<To> writer{to, is_brief};
  fields(writer, ours);
}

template <IsStruct Ours, class From>
void read(From from, Ours& ours) {
  Reader<From> reader{from};
  fields(reader, ours);
}

}  // namespace

capnp::Text::Reader as_text(const std::string& text) {
  return {text.c_str(), text.size()};
}

std::string as_string(capnp::Text::Reader text) {
  return {text.begin(), text.end()};
}

kj::ArrayPtr<const kj::byte> as_data(base::BytesView bytes) {
  return {reinterpret_cast<const kj::byte*>(bytes.data()), bytes.size()};
}

#define SLEIGHT_BOTH_WAYS(Ours, Theirs)                       \
  void put(const Ours& from, generated::Theirs::Builder to) { \
    write(from, to, false);                                   \
  }                                                           \
  Ours get(generated::Theirs::Reader from) {                  \
    Ours to{};                                                \
    read(from, to);                                           \
    return to;                                                \
  }

SLEIGHT_BOTH_WAYS(Refusal, Refusal)
SLEIGHT_BOTH_WAYS(Submission, Submission)
SLEIGHT_BOTH_WAYS(Submitted, Submitted)
SLEIGHT_BOTH_WAYS(JobView, JobView)
SLEIGHT_BOTH_WAYS(ListAsk, ListAsk)
SLEIGHT_BOTH_WAYS(JobPage, JobPage)
SLEIGHT_BOTH_WAYS(Touched, Touched)
SLEIGHT_BOTH_WAYS(ChangeAsk, ChangeAsk)
SLEIGHT_BOTH_WAYS(WatchPoint, WatchPoint)
SLEIGHT_BOTH_WAYS(LogPiece, LogPiece)
SLEIGHT_BOTH_WAYS(FetchAsk, FetchAsk)
SLEIGHT_BOTH_WAYS(FileView, FileRef)
SLEIGHT_BOTH_WAYS(ServerView, ServerView)
SLEIGHT_BOTH_WAYS(TokenAsk, TokenAsk)
SLEIGHT_BOTH_WAYS(TokenView, TokenView)

void put(const LogAsk& from, generated::LogAsk::Builder to) {
  to.setJob(from.job.value);
  to.setIsTail(!from.from);
  to.setFrom(from.from.value_or(0));
  to.setLines(from.lines);
  to.setBytesMax(from.bytes_max);
}

LogAsk get(generated::LogAsk::Reader from) {
  return {.job = {from.getJob()},
          .from = from.getIsTail() ? std::nullopt : std::optional(from.getFrom()),
          .lines = from.getLines(),
          .bytes_max = from.getBytesMax()};
}

void put(JobId job, const base::Result<Batch, Refusal>& from, generated::Batch::Builder to) {
  to.setJob(job.value);
  if (!from) {
    put(from.error(), to.initRefusal());
    return;
  }
  const Batch& batch = from.value();
  auto changes = to.initChanges(static_cast<unsigned>(batch.changes.size()));
  for (unsigned i = 0; i < changes.size(); ++i)
    write(batch.changes[i], changes[i], false);
  auto events = to.initEvents(static_cast<unsigned>(batch.events.size()));
  for (unsigned i = 0; i < events.size(); ++i) {
    std::string line = events::to_line(batch.events[i]);
    if (!line.empty() && line.back() == '\n') line.pop_back();
    events[i].setNumber(batch.events[i].number);
    events[i].setLine(as_text(line));
  }
  to.setMark(batch.mark);
  to.setSettled(batch.settled);
}

ArrivedBatch get(generated::Batch::Reader from) {
  ArrivedBatch to;
  to.job = {from.getJob()};
  if (from.hasRefusal()) to.refusal = get(from.getRefusal());
  for (const auto change : from.getChanges())
    read(change, to.changes.emplace_back());
  for (const auto event : from.getEvents())
    to.events.emplace_back(event.getNumber(), as_string(event.getLine()));
  to.mark = from.getMark();
  to.settled = from.getSettled();
  return to;
}

}  // namespace sleight::rpc
