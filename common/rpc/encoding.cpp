#include "common/rpc/encoding.h"

#include <algorithm>
#include <cmath>

#include "common/base/check.h"

namespace sleight::rpc {
namespace {

constexpr std::size_t k_line_bytes_max = 512;  // of a text in a list of jobs

/// Without its end where it is too long, whole characters of UTF-8 alone.
std::string_view cut(const std::string& text, std::size_t bytes_max) {
  if (text.size() <= bytes_max) return text;
  std::size_t size = bytes_max;
  while (size > 0 && (static_cast<unsigned char>(text[size]) & 0xC0U) == 0x80U)
    --size;
  return {text.data(), size};
}

/// A text needs a zero after its end, which a part of another one has not.
template <class Set>
void put_text(const std::string& text, std::size_t bytes_max, const Set& set) {
  const std::string_view short_text = cut(text, bytes_max);
  if (short_text.size() == text.size()) {
    set(as_text(text));
  } else {
    const std::string copy(short_text);
    set(as_text(copy));
  }
}

#define SLEIGHT_PUT_TEXT(builder, Field, text, bytes_max) \
  put_text(text, bytes_max, [&](capnp::Text::Reader put_of) { (builder).set##Field(put_of); })

template <class Ours, class Theirs>
Ours known(Theirs value, std::size_t count) {
  const auto index = static_cast<std::size_t>(value);
  return index < count ? static_cast<Ours>(index) : Ours::unknown;
}

JobState state_of(generated::JobState state) {
  return known<JobState>(state, k_job_states);
}

generated::JobState state_of(JobState state) {
  return static_cast<generated::JobState>(state);
}

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
static_assert(static_cast<int>(generated::FetchAsk::Kind::FAILURE_FILES) ==
              static_cast<int>(FetchKind::failure_files));

constexpr std::size_t k_extend_kinds = 5;
constexpr std::size_t k_fetch_kinds = 5;

unsigned size_of(std::size_t size, std::size_t size_max) {
  return static_cast<unsigned>(std::min(size, size_max));
}

void put_change(const StateChange& from, generated::StateChange::Builder to,
                std::size_t bytes_max) {
  to.setNumber(from.number);
  to.setTime(from.time_s);
  to.setState(state_of(from.state));
  SLEIGHT_PUT_TEXT(to, Reason, from.reason, bytes_max);
  to.setAttempt(from.attempt);
}

StateChange get_change(generated::StateChange::Reader from) {
  return {.number = from.getNumber(),
          .time_s = from.getTime(),
          .state = state_of(from.getState()),
          .reason = as_string(from.getReason()),
          .attempt = from.getAttempt()};
}

void put_target(const Target& from, generated::Target::Builder to) {
  CHECK_NE(from.job.has_value(), from.group.has_value());
  if (from.job) {
    to.setJob(from.job->value);
  } else {
    to.setGroup(from.group->value);
  }
}

// A kind of target that a newer client has names no job: number 0 is none.
Target get_target(generated::Target::Reader from) {
  if (from.isJob()) return Target::of(JobId{from.getJob()});
  if (from.isGroup()) return Target::of(GroupId{from.getGroup()});
  return Target::of(JobId{0});
}

template <class T>
std::optional<T> unless_zero(typename T::representation value) {
  return value == 0 ? std::nullopt : std::optional<T>(T{value});
}

double or_negative(const std::optional<double>& value) {
  return value ? *value : -1;
}

std::optional<double> unless_negative(double value) {
  return value >= 0 ? std::optional(value) : std::nullopt;
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

// ---------------------------------------------------------------------------------------- refusals

void put(const Refusal& from, generated::Refusal::Builder to) {
  to.setKind(static_cast<generated::Refusal::Kind>(from.kind));
  SLEIGHT_PUT_TEXT(to, Sentence, from.sentence, k_text_bytes_max);
  SLEIGHT_PUT_TEXT(to, WhatToDo, from.what_to_do, k_text_bytes_max);
  const unsigned count = size_of(from.diagnostics.size(), 2 * request::k_diagnostics_max);
  auto diagnostics = to.initDiagnostics(count);
  for (unsigned i = 0; i < count; ++i) {
    const request::Diagnostic& diagnostic = from.diagnostics[i];
    SLEIGHT_PUT_TEXT(diagnostics[i], File, diagnostic.file, k_line_bytes_max);
    diagnostics[i].setLine(diagnostic.place.line);
    diagnostics[i].setColumn(diagnostic.place.column);
    SLEIGHT_PUT_TEXT(diagnostics[i], Message, diagnostic.message, 4 * k_line_bytes_max);
  }
}

Refusal get(generated::Refusal::Reader from) {
  Refusal to = {.kind = known<RefusalKind>(from.getKind(), k_refusal_kinds),
                .sentence = as_string(from.getSentence()),
                .what_to_do = as_string(from.getWhatToDo())};
  for (const auto diagnostic : from.getDiagnostics()) {
    to.diagnostics.push_back({.file = as_string(diagnostic.getFile()),
                              .place = {diagnostic.getLine(), diagnostic.getColumn()},
                              .message = as_string(diagnostic.getMessage())});
  }
  return to;
}

// -------------------------------------------------------------------------------------- submitting

void put(const Submission& from, generated::Submission::Builder to) {
  to.setKey(as_text(from.key));
  to.setIsGroup(from.is_group);
  auto jobs = to.initJobs(static_cast<unsigned>(from.jobs.size()));
  for (unsigned i = 0; i < jobs.size(); ++i) {
    const JobAsk& job = from.jobs[i];
    jobs[i].setName(as_text(job.name));
    jobs[i].setRequest(as_text(job.request));
    jobs[i].setCores(job.cores.value_or(0));
    jobs[i].setRanks(job.ranks);
    jobs[i].setMemoryBytes(job.memory_bytes);
    jobs[i].setPriority(job.priority);
    jobs[i].setStrict(job.strict);
    auto options = jobs[i].initOptions(static_cast<unsigned>(job.options.size()));
    for (unsigned k = 0; k < options.size(); ++k) {
      options[k].setName(as_text(job.options[k].name));
      options[k].setValue(as_text(job.options[k].value));
    }
  }
}

Submission get(generated::Submission::Reader from) {
  Submission to = {.key = as_string(from.getKey()), .jobs = {}, .is_group = from.getIsGroup()};
  for (const auto job : from.getJobs()) {
    // Jobs without content cost a message nothing; limits.h refuses the one too many.
    if (to.jobs.size() > k_submission_jobs_max) break;
    JobAsk ask = {.name = as_string(job.getName()),
                  .request = as_string(job.getRequest()),
                  .cores = {},
                  .ranks = job.getRanks(),
                  .memory_bytes = job.getMemoryBytes(),
                  .priority = job.getPriority(),
                  .strict = job.getStrict()};
    if (job.getCores() > 0) ask.cores = job.getCores();
    for (const auto option : job.getOptions()) {
      if (ask.options.size() > k_options_max) break;
      ask.options.push_back({as_string(option.getName()), as_string(option.getValue())});
    }
    to.jobs.push_back(std::move(ask));
  }
  return to;
}

void put(const Submitted& from, generated::Submitted::Builder to) {
  auto jobs = to.initJobs(static_cast<unsigned>(from.jobs.size()));
  for (unsigned i = 0; i < jobs.size(); ++i)
    jobs.set(i, from.jobs[i].value);
  to.setGroup(from.group ? from.group->value : 0);
  to.setWasKnown(from.was_known);
}

Submitted get(generated::Submitted::Reader from) {
  Submitted to = {
      .jobs = {}, .group = unless_zero<GroupId>(from.getGroup()), .was_known = from.getWasKnown()};
  for (const std::uint64_t job : from.getJobs())
    to.jobs.push_back({job});
  return to;
}

// -------------------------------------------------------------------------------------------- jobs

void put(const JobView& from, generated::JobView::Builder to, Detail detail) {
  const std::size_t bytes_max = detail == Detail::brief ? k_line_bytes_max : k_text_bytes_max;
  to.setId(from.id.value);
  to.setGroup(from.group ? from.group->value : 0);
  to.setUser(from.user);
  SLEIGHT_PUT_TEXT(to, Name, from.name, k_name_bytes_max);
  SLEIGHT_PUT_TEXT(to, World, from.world, k_name_bytes_max);
  to.setState(state_of(from.state));
  SLEIGHT_PUT_TEXT(to, Reason, from.reason, bytes_max);
  to.setPlace(from.place);
  SLEIGHT_PUT_TEXT(to, NotYet, from.not_yet, bytes_max);
  to.setAttempt(from.attempt);
  to.setPriority(from.priority);
  to.setCoresWanted(from.cores_wanted.value_or(0));
  to.setCores(from.cores);
  to.setRanks(from.ranks);
  to.setMemoryBytes(from.memory_bytes);
  to.setStrict(from.strict);
  to.setPinned(from.pinned);
  to.setScansDone(from.scans_done);
  to.setScansTotal(from.scans_total);
  to.setFound(from.solutions.found);
  to.setFoundWanted(from.solutions.found_wanted);
  to.setInProportion(from.solutions.in_proportion);
  to.setInProportionWanted(from.solutions.in_proportion_wanted);
  const unsigned kinds = size_of(from.failures.size(), 64);
  if (kinds > 0) {
    auto failures = to.initFailures(kinds);
    for (unsigned i = 0; i < kinds; ++i) {
      SLEIGHT_PUT_TEXT(failures[i], Simulation, from.failures[i].simulation, k_name_bytes_max);
      failures[i].setCount(from.failures[i].count);
    }
  }
  to.setSimulationsPerSecond(from.simulations_per_s);
  to.setLeft(or_negative(from.left_s));
  to.setSolutionsLeft(or_negative(from.solutions_left_s));
  to.setCoreSeconds(from.core_s);
  to.setSubmitted(from.submitted_s);
  to.setStarted(from.started_s);
  to.setEnded(from.ended_s);
  to.setBytes(from.bytes);
  to.setDeletedAt(from.deleted_at_s);
  SLEIGHT_PUT_TEXT(to, Digest, from.digest, k_name_bytes_max);
  SLEIGHT_PUT_TEXT(to, ResultsVersion, from.results_version, k_name_bytes_max);
  SLEIGHT_PUT_TEXT(to, EndWords, from.end_words, bytes_max);
  if (detail == Detail::brief) return;
  const unsigned lines = size_of(from.last_log_lines.size(), k_last_log_lines);
  auto log = to.initLastLogLines(lines);
  for (unsigned i = 0; i < lines; ++i)
    put_text(from.last_log_lines[i], 4 * k_line_bytes_max,
             [&](capnp::Text::Reader line) { log.set(i, line); });
  SLEIGHT_PUT_TEXT(to, RepeatCommand, from.repeat_command, k_text_bytes_max);
  const unsigned changes = size_of(from.history.size(), k_history_max);
  auto history = to.initHistory(changes);
  for (unsigned i = 0; i < changes; ++i)
    put_change(from.history[from.history.size() - changes + i], history[i], k_line_bytes_max);
}

JobView get(generated::JobView::Reader from) {
  JobView to = {.id = {from.getId()},
                .group = unless_zero<GroupId>(from.getGroup()),
                .user = from.getUser(),
                .name = as_string(from.getName()),
                .world = as_string(from.getWorld()),
                .state = state_of(from.getState()),
                .reason = as_string(from.getReason()),
                .place = from.getPlace(),
                .not_yet = as_string(from.getNotYet()),
                .attempt = from.getAttempt(),
                .priority = from.getPriority(),
                .cores_wanted = {},
                .cores = from.getCores(),
                .ranks = from.getRanks(),
                .memory_bytes = from.getMemoryBytes(),
                .strict = from.getStrict(),
                .pinned = from.getPinned(),
                .scans_done = from.getScansDone(),
                .scans_total = from.getScansTotal(),
                .solutions = {.found = from.getFound(),
                              .found_wanted = from.getFoundWanted(),
                              .in_proportion = from.getInProportion(),
                              .in_proportion_wanted = from.getInProportionWanted()},
                .failures = {},
                .simulations_per_s = from.getSimulationsPerSecond(),
                .left_s = unless_negative(from.getLeft()),
                .solutions_left_s = unless_negative(from.getSolutionsLeft()),
                .core_s = from.getCoreSeconds(),
                .submitted_s = from.getSubmitted(),
                .started_s = from.getStarted(),
                .ended_s = from.getEnded(),
                .bytes = from.getBytes(),
                .deleted_at_s = from.getDeletedAt(),
                .digest = as_string(from.getDigest()),
                .results_version = as_string(from.getResultsVersion()),
                .end_words = as_string(from.getEndWords()),
                .last_log_lines = {},
                .repeat_command = as_string(from.getRepeatCommand()),
                .history = {}};
  if (from.getCoresWanted() > 0) to.cores_wanted = from.getCoresWanted();
  for (const auto failure : from.getFailures())
    to.failures.push_back({as_string(failure.getSimulation()), failure.getCount()});
  for (const auto line : from.getLastLogLines())
    to.last_log_lines.push_back(as_string(line));
  for (const auto change : from.getHistory())
    to.history.push_back(get_change(change));
  return to;
}

void put(const ListAsk& from, generated::ListAsk::Builder to) {
  to.setGroup(from.group ? from.group->value : 0);
  to.setUser(from.user ? static_cast<std::int64_t>(*from.user) : -1);
  auto states = to.initStates(static_cast<unsigned>(from.states.size()));
  for (unsigned i = 0; i < states.size(); ++i)
    states.set(i, state_of(from.states[i]));
  to.setNamePart(as_text(from.name_part));
  to.setOldestFirst(!from.newest_first);
  to.setCount(from.count);
  to.setCursor(as_text(from.cursor));
}

ListAsk get(generated::ListAsk::Reader from) {
  ListAsk to = {.group = unless_zero<GroupId>(from.getGroup()),
                .user = {},
                .states = {},
                .name_part = as_string(from.getNamePart()),
                .newest_first = !from.getOldestFirst(),
                .count = from.getCount(),
                .cursor = as_string(from.getCursor())};
  if (from.getUser() >= 0) to.user = static_cast<std::uint32_t>(from.getUser());
  for (const auto state : from.getStates()) {
    if (to.states.size() > k_job_states) break;
    to.states.push_back(state_of(state));
  }
  return to;
}

void put(const JobPage& from, generated::JobPage::Builder to) {
  auto jobs = to.initJobs(static_cast<unsigned>(from.jobs.size()));
  for (unsigned i = 0; i < jobs.size(); ++i)
    put(from.jobs[i], jobs[i], Detail::brief);
  to.setCursor(as_text(from.cursor));
  to.setTotal(from.total);
}

JobPage get(generated::JobPage::Reader from) {
  JobPage to = {.jobs = {}, .cursor = as_string(from.getCursor()), .total = from.getTotal()};
  for (const auto job : from.getJobs())
    to.jobs.push_back(get(job));
  return to;
}

void put(const std::vector<Touched>& from, capnp::List<generated::Touched>::Builder to) {
  for (unsigned i = 0; i < to.size(); ++i) {
    to[i].setJob(from[i].job.value);
    to[i].setState(state_of(from[i].state));
    SLEIGHT_PUT_TEXT(to[i], Words, from[i].words, k_line_bytes_max);
  }
}

std::vector<Touched> get(capnp::List<generated::Touched>::Reader from) {
  std::vector<Touched> to;
  for (const auto job : from) {
    to.push_back({.job = {job.getJob()},
                  .state = state_of(job.getState()),
                  .words = as_string(job.getWords())});
  }
  return to;
}

void put(const ChangeAsk& from, generated::ChangeAsk::Builder to) {
  put_target(from.target, to.initTarget());
  to.setKind(static_cast<generated::ChangeAsk::Kind>(from.kind));
  auto extension = to.initExtension();
  extension.setBy(static_cast<generated::Extension::By>(from.extension.by));
  extension.setTo(from.extension.to);
  to.setPriority(from.priority);
}

ChangeAsk get(generated::ChangeAsk::Reader from) {
  const auto extension = from.getExtension();
  return {.target = get_target(from.getTarget()),
          .kind = known<ChangeKind>(from.getKind(), k_change_kinds),
          .extension = {.by = known<ExtendBy>(extension.getBy(), k_extend_kinds),
                        .to = extension.getTo()},
          .priority = from.getPriority()};
}

// ---------------------------------------------------------------------------------------- watching

void put(const WatchPoint& from, generated::WatchPoint::Builder to) {
  to.setJob(from.job.value);
  to.setEvent(from.event);
  to.setChange(from.change);
  to.setMark(from.mark);
}

WatchPoint get(generated::WatchPoint::Reader from) {
  return {.job = {from.getJob()},
          .event = from.getEvent(),
          .change = from.getChange(),
          .mark = from.getMark()};
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
    put_change(batch.changes[i], changes[i], 4 * k_line_bytes_max);
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
    to.changes.push_back(get_change(change));
  for (const auto event : from.getEvents())
    to.events.emplace_back(event.getNumber(), as_string(event.getLine()));
  to.mark = from.getMark();
  to.settled = from.getSettled();
  return to;
}

// -------------------------------------------------------------------------------------------- logs

void put(const LogAsk& from, generated::LogAsk::Builder to) {
  to.setJob(from.job.value);
  to.setIsTail(!from.from);
  to.setFrom(from.from.value_or(0));
  to.setLines(from.lines);
  to.setBytesMax(from.bytes_max);
}

LogAsk get(generated::LogAsk::Reader from) {
  LogAsk to = {.job = {from.getJob()},
               .from = {},
               .lines = from.getLines(),
               .bytes_max = from.getBytesMax()};
  if (!from.getIsTail()) to.from = from.getFrom();
  return to;
}

void put(const LogPiece& from, generated::LogPiece::Builder to) {
  to.setFirst(from.first);
  to.setBytes(as_data(std::as_bytes(std::span(from.text))));
  to.setEnd(from.end);
  to.setIsOver(from.is_over);
}

LogPiece get(generated::LogPiece::Reader from) {
  const auto bytes = from.getBytes();
  return {.first = from.getFirst(),
          .text = {reinterpret_cast<const char*>(bytes.begin()), bytes.size()},
          .end = from.getEnd(),
          .is_over = from.getIsOver()};
}

// ---------------------------------------------------------------------------------------- fetching

void put(const FetchAsk& from, generated::FetchAsk::Builder to) {
  to.setJob(from.job.value);
  to.setKind(static_cast<generated::FetchAsk::Kind>(from.kind));
  auto ids = to.initIds(static_cast<unsigned>(from.ids.size()));
  for (unsigned i = 0; i < ids.size(); ++i)
    ids.set(i, from.ids[i]);
  to.setAfter(as_text(from.after));
  to.setSha256Wanted(as_text(from.sha256_wanted));
}

FetchAsk get(generated::FetchAsk::Reader from) {
  FetchAsk to = {.job = {from.getJob()},
                 .kind = known<FetchKind>(from.getKind(), k_fetch_kinds),
                 .ids = {},
                 .after = as_string(from.getAfter()),
                 .sha256_wanted = as_string(from.getSha256Wanted())};
  for (const std::uint64_t id : from.getIds())
    to.ids.push_back(id);
  return to;
}

void put(const FileView& from, generated::FileRef::Builder to) {
  to.setName(as_text(from.name));
  to.setSize(from.size);
  to.setSha256(as_text(from.sha256));
}

FileView get(generated::FileRef::Reader from) {
  return {.name = as_string(from.getName()),
          .size = from.getSize(),
          .sha256 = as_string(from.getSha256())};
}

// ------------------------------------------------------------------------------------------ server

void put(const ServerView& from, generated::ServerView::Builder to) {
  SLEIGHT_PUT_TEXT(to, Version, from.version, k_name_bytes_max);
  SLEIGHT_PUT_TEXT(to, ResultsVersion, from.results_version, k_name_bytes_max);
  SLEIGHT_PUT_TEXT(to, StateFolder, from.state_folder, k_text_bytes_max);
  to.setPid(from.pid);
  to.setUp(from.up_s);
  to.setDraining(from.draining);
  SLEIGHT_PUT_TEXT(to, Backend, from.backend, k_name_bytes_max);
  to.setCores(from.cores);
  to.setCoresUsed(from.cores_used);
  to.setMemoryBytes(from.memory_bytes);
  to.setMemoryUsedBytes(from.memory_used_bytes);
  to.setDiskFreeBytes(from.disk_free_bytes);
  to.setDiskReserveBytes(from.disk_reserve_bytes);
  SLEIGHT_PUT_TEXT(to, KeepingRule, from.keeping_rule, k_text_bytes_max);
  auto limits = to.initLimits(size_of(from.limits.size(), 64));
  for (unsigned i = 0; i < limits.size(); ++i) {
    SLEIGHT_PUT_TEXT(limits[i], Name, from.limits[i].name, k_line_bytes_max);
    SLEIGHT_PUT_TEXT(limits[i], Value, from.limits[i].value, k_line_bytes_max);
  }
  auto counts = to.initCounts(size_of(from.counts.size(), k_job_states));
  for (unsigned i = 0; i < counts.size(); ++i) {
    counts[i].setState(state_of(from.counts[i].state));
    counts[i].setCount(from.counts[i].count);
  }
  to.setConnections(from.connections);
  to.setWatchers(from.watchers);
  SLEIGHT_PUT_TEXT(to, Address, from.address, k_line_bytes_max);
  SLEIGHT_PUT_TEXT(to, Fingerprint, from.fingerprint, k_line_bytes_max);
}

ServerView get(generated::ServerView::Reader from) {
  ServerView to = {.version = as_string(from.getVersion()),
                   .results_version = as_string(from.getResultsVersion()),
                   .state_folder = as_string(from.getStateFolder()),
                   .pid = from.getPid(),
                   .up_s = from.getUp(),
                   .draining = from.getDraining(),
                   .backend = as_string(from.getBackend()),
                   .cores = from.getCores(),
                   .cores_used = from.getCoresUsed(),
                   .memory_bytes = from.getMemoryBytes(),
                   .memory_used_bytes = from.getMemoryUsedBytes(),
                   .disk_free_bytes = from.getDiskFreeBytes(),
                   .disk_reserve_bytes = from.getDiskReserveBytes(),
                   .keeping_rule = as_string(from.getKeepingRule()),
                   .limits = {},
                   .counts = {},
                   .connections = from.getConnections(),
                   .watchers = from.getWatchers(),
                   .address = as_string(from.getAddress()),
                   .fingerprint = as_string(from.getFingerprint())};
  for (const auto limit : from.getLimits())
    to.limits.push_back({as_string(limit.getName()), as_string(limit.getValue())});
  for (const auto count : from.getCounts())
    to.counts.push_back({state_of(count.getState()), count.getCount()});
  return to;
}

}  // namespace sleight::rpc
