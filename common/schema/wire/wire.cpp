#include "common/schema/wire/wire.h"

#include <capnp/message.h>
#include <capnp/serialize.h>
#include <kj/exception.h>
#include <worker.capnp.h>

#include <algorithm>
#include <cstring>
#include <vector>

#include "common/base/check.h"

namespace sleight::schema::wire {
namespace {

kj::ArrayPtr<const kj::byte> as_data(base::BytesView bytes) {
  return {reinterpret_cast<const kj::byte*>(bytes.data()), bytes.size()};
}

base::Bytes as_bytes(capnp::Data::Reader data) {
  const auto* first = reinterpret_cast<const std::byte*>(data.begin());
  return {first, first + data.size()};
}

capnp::Text::Reader as_text(const std::string& text) {
  return {text.c_str(), text.size()};
}

/// Returns the whole text; cStr() would end at an embedded zero.
std::string as_string(capnp::Text::Reader text) {
  return {text.begin(), text.end()};
}

template <class T, class Builder>
void put_list(Builder list, const std::vector<T>& values) {
  for (unsigned i = 0; i < values.size(); ++i)
    list.set(i, values[i]);
}

template <class T, class Reader>
std::vector<T> get_list(Reader list) {
  std::vector<T> values;
  values.reserve(list.size());
  for (const T value : list)
    values.push_back(value);
  return values;
}

void put_unit(const plan::Unit& unit, generated::Unit::Builder out) {
  out.setChain(unit.replica.chain.value);
  out.setReplica(unit.replica.replica.value);
  out.setSeed(unit.seed);
  out.setFirstScan(unit.first_scan.value);
  out.setScans(unit.scans);
  out.setStarts(unit.starts);
  out.setLineage(unit.lineage);
  const auto put = [](auto list, const std::vector<double>& values) { put_list(list, values); };
  put(out.initInverseTemperatures(static_cast<unsigned>(unit.inverse_temperatures.size())),
      unit.inverse_temperatures);
  put(out.initProposalScales(static_cast<unsigned>(unit.proposal_scales.size())),
      unit.proposal_scales);
  put(out.initExcursion(static_cast<unsigned>(unit.excursion.size())), unit.excursion);
}

plan::Unit get_unit(generated::Unit::Reader in) {
  return {.replica = {base::ChainId{in.getChain()}, base::ReplicaId{in.getReplica()}},
          .seed = in.getSeed(),
          .first_scan = base::ScanIndex{in.getFirstScan()},
          .scans = in.getScans(),
          .starts = in.getStarts(),
          .lineage = in.getLineage(),
          .inverse_temperatures = get_list<double>(in.getInverseTemperatures()),
          .proposal_scales = get_list<double>(in.getProposalScales()),
          .excursion = get_list<double>(in.getExcursion())};
}

void put_scan(const plan::ScanRecord& record, generated::Scan::Builder out) {
  out.setLogPrior(record.log_prior);
  out.setLogConstraint(record.log_constraint);
  out.setSatisfied(record.satisfied);
  out.setLineage(record.lineage);
  out.setInverseTemperature(record.inverse_temperature);
  put_list(out.initProposed(static_cast<unsigned>(record.proposed.size())), record.proposed);
  put_list(out.initAccepted(static_cast<unsigned>(record.accepted.size())), record.accepted);
  put_list(out.initOutcome(static_cast<unsigned>(record.outcome.size())), record.outcome);
  out.setState(as_data(record.state));
  if (record.failures.total() > 0) {
    auto failures = out.initFailures(plan::k_failure_kinds);
    for (unsigned kind = 0; kind < plan::k_failure_kinds; ++kind)
      failures.set(kind, record.failures.by_kind[kind]);
  }
  out.setOverlappingStarts(record.overlapping_starts);
  put_list(out.initMethodValues(static_cast<unsigned>(record.method_values.size())),
           record.method_values);
}

/// Failures are either absent, or have a count for each kind.
bool fits(generated::Scan::Reader in) {
  return in.getFailures().size() == 0 || in.getFailures().size() == plan::k_failure_kinds;
}

plan::FailureCounts get_failures(generated::Scan::Reader in) {
  plan::FailureCounts counts;
  for (unsigned kind = 0; kind < in.getFailures().size(); ++kind)
    counts.by_kind[kind] = in.getFailures()[kind];
  return counts;
}

plan::ScanRecord get_scan(generated::Scan::Reader in) {
  return {.log_prior = in.getLogPrior(),
          .log_constraint = in.getLogConstraint(),
          .satisfied = in.getSatisfied(),
          .lineage = in.getLineage(),
          .inverse_temperature = in.getInverseTemperature(),
          .proposed = get_list<std::uint32_t>(in.getProposed()),
          .accepted = get_list<std::uint32_t>(in.getAccepted()),
          .outcome = get_list<double>(in.getOutcome()),
          .failures = get_failures(in),
          .overlapping_starts = in.getOverlappingStarts(),
          .method_values = get_list<double>(in.getMethodValues()),
          .state = as_bytes(in.getState())};
}

void put_part(const plan::LadderPart& part, generated::LadderPart::Builder out) {
  out.setLevels(part.levels);
  out.setFirstLevel(part.first_level);
  put_list(out.initInverseTemperatures(static_cast<unsigned>(part.inverse_temperatures.size())),
           part.inverse_temperatures);
  auto scales = out.initProposalScales(static_cast<unsigned>(part.proposal_scales.size()));
  for (unsigned i = 0; i < part.proposal_scales.size(); ++i)
    put_list(scales.init(i, static_cast<unsigned>(part.proposal_scales[i].size())),
             part.proposal_scales[i]);
  out.setEndScan(part.end_scan);
  out.setScansMax(part.scans_max);
}

plan::LadderPart get_part(generated::LadderPart::Reader in) {
  plan::LadderPart part{.levels = in.getLevels(),
                        .first_level = in.getFirstLevel(),
                        .inverse_temperatures = get_list<double>(in.getInverseTemperatures()),
                        .proposal_scales = {},
                        .end_scan = in.getEndScan(),
                        .scans_max = in.getScansMax()};
  for (const auto scales : in.getProposalScales())
    part.proposal_scales.push_back(get_list<double>(scales));
  return part;
}

void put_assignment(const Assignment& assignment, generated::Assignment::Builder out) {
  const std::vector<plan::Unit>& units = assignment.block.members;
  CHECK_EQ(units.size(), assignment.states.size());
  out.setEpoch(assignment.epoch);
  out.setAssignment(assignment.assignment);
  auto members = out.initMembers(static_cast<unsigned>(units.size()));
  for (unsigned i = 0; i < units.size(); ++i) {
    put_unit(units[i], members[i].initUnit());
    if (assignment.states[i]) members[i].setState(as_data(*assignment.states[i]));
  }
  if (assignment.block.ladder) put_part(*assignment.block.ladder, out.initPart());
}

/// A unit has one inverse temperature for all scans, or one per scan.
bool fits(const plan::Unit& unit) {
  const std::size_t given = unit.inverse_temperatures.size();
  return unit.scans > 0 && (given == 1 || given == unit.scans);
}

/// Returns whether each member has a level, and the levels are within the ladder.
bool fits(const plan::Block& block) {
  if (!std::ranges::all_of(block.members, [](const auto& unit) { return fits(unit); }))
    return false;
  if (!block.ladder) return block.members.size() == 1;
  const plan::LadderPart& part = *block.ladder;
  const std::size_t count = block.members.size();
  return count > 0 && part.inverse_temperatures.size() == count &&
         part.proposal_scales.size() == count && part.levels >= count &&
         part.first_level <= part.levels - count &&
         std::ranges::all_of(block.members, [](const auto& unit) { return unit.scans == 1; });
}

base::Result<Message, std::string> get_assignment(generated::Assignment::Reader in) {
  Assignment assignment{
      .epoch = in.getEpoch(), .assignment = in.getAssignment(), .block = {}, .states = {}};
  for (const auto member : in.getMembers()) {
    assignment.block.members.push_back(get_unit(member.getUnit()));
    plan::GivenState& state = assignment.states.emplace_back();
    if (member.isState()) state = as_bytes(member.getState());
  }
  if (in.isPart()) assignment.block.ladder = get_part(in.getPart());
  if (!fits(assignment.block)) return std::string("an assignment has inconsistent parts");
  return Message(std::move(assignment));
}

void put_cache(const plan::CacheUse& use, generated::CacheUse::Builder out) {
  out.setHits(use.hits);
  out.setMisses(use.misses);
  out.setEvictions(use.evictions);
  out.setBytes(use.bytes);
  out.setBytesMax(use.bytes_max);
}

plan::CacheUse get_cache(generated::CacheUse::Reader in) {
  return {.hits = in.getHits(),
          .misses = in.getMisses(),
          .evictions = in.getEvictions(),
          .bytes = in.getBytes(),
          .bytes_max = in.getBytesMax()};
}

void put_delivery(const Delivery& delivery, generated::Delivery::Builder out) {
  out.setEpoch(delivery.epoch);
  out.setAssignment(delivery.assignment);
  auto results = out.initResults(static_cast<unsigned>(delivery.results.size()));
  for (unsigned i = 0; i < delivery.results.size(); ++i) {
    const plan::UnitResult& result = delivery.results[i];
    results[i].setChain(result.unit.replica.chain.value);
    results[i].setReplica(result.unit.replica.replica.value);
    results[i].setFirstScan(result.unit.first_scan.value);
    auto scans = results[i].initScans(static_cast<unsigned>(result.scans.size()));
    for (unsigned k = 0; k < result.scans.size(); ++k)
      put_scan(result.scans[k], scans[k]);
    results[i].setStateAfter(as_data(result.state_after));
    results[i].setCostSeconds(result.cost_s);
    results[i].setSimulations(result.simulations);
    auto failed = results[i].initFailed(static_cast<unsigned>(result.failed.size()));
    for (unsigned k = 0; k < result.failed.size(); ++k) {
      const plan::SimulationFailure& failure = result.failed[k].failure;
      failed[k].setScan(result.failed[k].scan.value);
      failed[k].setKind(static_cast<std::uint32_t>(failure.kind));
      failed[k].setMessage(as_text(failure.message));
      failed[k].setState(as_data(failure.state));
    }
  }
  put_cache(delivery.cache, out.initCache());
}

base::Result<Message, std::string> get_delivery(generated::Delivery::Reader in) {
  Delivery delivery{.epoch = in.getEpoch(),
                    .assignment = in.getAssignment(),
                    .results = {},
                    .cache = get_cache(in.getCache())};
  for (const auto from : in.getResults()) {
    if (from.getScans().size() == 0) return std::string("a result has no scans");
    plan::UnitResult& result = delivery.results.emplace_back();
    result.unit = {.replica = {base::ChainId{from.getChain()}, base::ReplicaId{from.getReplica()}},
                   .first_scan = base::ScanIndex{from.getFirstScan()},
                   .scans = from.getScans().size()};
    result.scans.reserve(from.getScans().size());
    for (const auto scan : from.getScans()) {
      if (!fits(scan)) return std::string("the failures of a scan have unknown kinds");
      result.scans.push_back(get_scan(scan));
    }
    for (const auto failed : from.getFailed()) {
      if (failed.getKind() >= plan::k_failure_kinds)
        return std::string("a failed simulation has an unknown kind");
      result.failed.push_back({.scan = base::ScanIndex{failed.getScan()},
                               .failure = {.kind = static_cast<plan::FailureKind>(failed.getKind()),
                                           .message = as_string(failed.getMessage()),
                                           .state = as_bytes(failed.getState())}});
    }
    result.state_after = as_bytes(from.getStateAfter());
    result.cost_s = from.getCostSeconds();
    result.simulations = from.getSimulations();
  }
  return Message(std::move(delivery));
}

struct Put {
  generated::Message::Builder out;

  void operator()(const Hello& hello) {
    auto builder = out.initHello();
    builder.setResultsVersion(as_text(hello.results_version));
    builder.setIdentity(as_text(hello.identity));
    builder.setThreads(hello.threads);
  }
  void operator()(const Assignment& assignment) {
    put_assignment(assignment, out.initAssignment());
  }
  void operator()(const Stop&) { out.setStop(); }
  void operator()(const Delivery& delivery) { put_delivery(delivery, out.initDelivery()); }
  void operator()(const Ping& ping) { out.setPing(ping.epoch); }
  void operator()(const Pong& pong) {
    auto builder = out.initPong();
    builder.setEpoch(pong.epoch);
    put_list(builder.initAssignments(static_cast<unsigned>(pong.assignments.size())),
             pong.assignments);
  }
  void operator()(const Failure& failure) { out.setFailure(as_text(failure.reason)); }
};

base::Result<Message, std::string> get_message(generated::Message::Reader in) {
  switch (in.which()) {
    case generated::Message::HELLO: {
      const auto hello = in.getHello();
      if (hello.getThreads() == 0) return std::string("a hello message has 0 threads");
      return Message(Hello{.results_version = as_string(hello.getResultsVersion()),
                           .identity = as_string(hello.getIdentity()),
                           .threads = hello.getThreads()});
    }
    case generated::Message::ASSIGNMENT:
      return get_assignment(in.getAssignment());
    case generated::Message::STOP:
      return Message(Stop{});
    case generated::Message::DELIVERY:
      return get_delivery(in.getDelivery());
    case generated::Message::PING:
      return Message(Ping{.epoch = in.getPing()});
    case generated::Message::PONG:
      return Message(Pong{.epoch = in.getPong().getEpoch(),
                          .assignments = get_list<std::uint64_t>(in.getPong().getAssignments())});
    case generated::Message::FAILURE:
      return Message(Failure{.reason = as_string(in.getFailure())});
  }
  return std::string("the message has an unknown kind");
}

}  // namespace

base::Bytes encode(const Message& message) {
  capnp::MallocMessageBuilder builder;
  std::visit(Put{builder.initRoot<generated::Message>()}, message);
  const kj::Array<capnp::word> words = capnp::messageToFlatArray(builder);
  const kj::ArrayPtr<const kj::byte> bytes = words.asBytes();
  CHECK_LE(bytes.size(), k_message_bytes_max);
  const auto* first = reinterpret_cast<const std::byte*>(bytes.begin());
  return {first, first + bytes.size()};
}

base::Result<Message, std::string> decode(base::BytesView bytes) {
  if (bytes.size() > k_message_bytes_max) return std::string("the message exceeds the size limit");
  // Copy the bytes into words, because they may be unaligned.
  std::vector<capnp::word> words(bytes.size() / sizeof(capnp::word));
  if (words.size() * sizeof(capnp::word) != bytes.size()) {
    return std::string("the message's size is not a multiple of 8 bytes");
  }
  if (!words.empty()) std::memcpy(words.data(), bytes.data(), bytes.size());
  try {
    capnp::ReaderOptions limits;
    limits.traversalLimitInWords = 8 * words.size() + 1024;
    capnp::FlatArrayMessageReader reader(
        kj::ArrayPtr<const capnp::word>(words.data(), words.size()), limits);
    return get_message(reader.getRoot<generated::Message>());
  } catch (const kj::Exception& failure) {
    return std::string("the message is unreadable: ") + failure.getDescription().cStr();
  }
}

}  // namespace sleight::schema::wire
