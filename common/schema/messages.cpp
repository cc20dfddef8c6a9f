#include "common/schema/messages.h"

#include <capnp/message.h>
#include <capnp/serialize.h>
#include <kj/exception.h>
#include <worker.capnp.h>

#include <cstring>
#include <vector>

#include "common/base/check.h"

namespace sleight::schema {
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

/// All of a text: cStr() alone would end at a zero within.
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

void put_unit(const plan::Unit& unit, wire::Unit::Builder out) {
  out.setChain(unit.replica.chain.value);
  out.setReplica(unit.replica.replica.value);
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

plan::Unit get_unit(wire::Unit::Reader in) {
  return {.replica = {base::ChainId{in.getChain()}, base::ReplicaId{in.getReplica()}},
          .first_scan = base::ScanIndex{in.getFirstScan()},
          .scans = in.getScans(),
          .starts = in.getStarts(),
          .lineage = in.getLineage(),
          .inverse_temperatures = get_list<double>(in.getInverseTemperatures()),
          .proposal_scales = get_list<double>(in.getProposalScales()),
          .excursion = get_list<double>(in.getExcursion())};
}

void put_scan(const plan::ScanRecord& record, wire::Scan::Builder out) {
  out.setLogPrior(record.log_prior);
  out.setLogConstraint(record.log_constraint);
  out.setSatisfied(record.satisfied);
  out.setLineage(record.lineage);
  out.setInverseTemperature(record.inverse_temperature);
  put_list(out.initProposed(static_cast<unsigned>(record.proposed.size())), record.proposed);
  put_list(out.initAccepted(static_cast<unsigned>(record.accepted.size())), record.accepted);
  put_list(out.initOutcome(static_cast<unsigned>(record.outcome.size())), record.outcome);
  out.setState(as_data(record.state));
}

plan::ScanRecord get_scan(wire::Scan::Reader in) {
  return {.log_prior = in.getLogPrior(),
          .log_constraint = in.getLogConstraint(),
          .satisfied = in.getSatisfied(),
          .lineage = in.getLineage(),
          .inverse_temperature = in.getInverseTemperature(),
          .proposed = get_list<std::uint32_t>(in.getProposed()),
          .accepted = get_list<std::uint32_t>(in.getAccepted()),
          .outcome = get_list<double>(in.getOutcome()),
          .state = as_bytes(in.getState())};
}

void put_result(const plan::UnitResult& result, wire::Result::Builder out) {
  put_unit(result.unit, out.initUnit());
  auto scans = out.initScans(static_cast<unsigned>(result.scans.size()));
  for (unsigned i = 0; i < result.scans.size(); ++i)
    put_scan(result.scans[i], scans[i]);
  out.setStateAfter(as_data(result.state_after));
  out.setCostSeconds(result.cost_s);
}

/// Writes each kind of message into the union.
struct Put {
  wire::Message::Builder out;

  void operator()(const Hello& hello) {
    auto builder = out.initHello();
    builder.setProgramVersion(as_text(hello.program_version));
    builder.setIdentity(as_text(hello.identity));
  }
  void operator()(const Assignment& assignment) {
    auto builder = out.initAssignment();
    put_unit(assignment.unit, builder.initUnit());
    builder.setState(as_data(assignment.state));
  }
  void operator()(const Stop&) { out.setStop(); }
  void operator()(const plan::UnitResult& result) { put_result(result, out.initResult()); }
  void operator()(const Failure& failure) { out.setFailure(as_text(failure.reason)); }
};

/// Each scan has an inverse temperature.
bool fits(const plan::Unit& unit) {
  const std::size_t given = unit.inverse_temperatures.size();
  return given == 1 || given == unit.scans;
}

/// A result, when its length fits its unit.
base::Result<Message, std::string> get_result(wire::Result::Reader in) {
  plan::UnitResult result{.unit = get_unit(in.getUnit()),
                          .scans = {},
                          .state_after = as_bytes(in.getStateAfter()),
                          .cost_s = in.getCostSeconds()};
  if (in.getScans().size() != result.unit.scans) {
    return std::string("a result with another number of scans than its unit");
  }
  if (!fits(result.unit)) return std::string("a result without its inverse temperatures");
  result.scans.reserve(result.unit.scans);
  for (const auto scan : in.getScans())
    result.scans.push_back(get_scan(scan));
  return Message(std::move(result));
}

base::Result<Message, std::string> get_message(wire::Message::Reader in) {
  switch (in.which()) {
    case wire::Message::HELLO:
      return Message(Hello{.program_version = as_string(in.getHello().getProgramVersion()),
                           .identity = as_string(in.getHello().getIdentity())});
    case wire::Message::ASSIGNMENT: {
      Assignment assignment{.unit = get_unit(in.getAssignment().getUnit()),
                            .state = as_bytes(in.getAssignment().getState())};
      if (assignment.unit.scans == 0) return std::string("an assignment of no scans");
      if (!fits(assignment.unit)) return std::string("an assignment without inverse temperatures");
      return Message(std::move(assignment));
    }
    case wire::Message::STOP:
      return Message(Stop{});
    case wire::Message::RESULT:
      return get_result(in.getResult());
    case wire::Message::FAILURE:
      return Message(Failure{.reason = as_string(in.getFailure())});
  }
  return std::string("a message of an unknown kind");
}

}  // namespace

base::Bytes encode(const Message& message) {
  capnp::MallocMessageBuilder builder;
  std::visit(Put{builder.initRoot<wire::Message>()}, message);
  const kj::Array<capnp::word> words = capnp::messageToFlatArray(builder);
  const kj::ArrayPtr<const kj::byte> bytes = words.asBytes();
  CHECK_LE(bytes.size(), k_message_bytes_max);
  const auto* first = reinterpret_cast<const std::byte*>(bytes.begin());
  return {first, first + bytes.size()};
}

base::Result<Message, std::string> decode(base::BytesView bytes) {
  if (bytes.size() > k_message_bytes_max) return std::string("a message beyond the size limit");
  // Copied into words: the bytes may lie at any address.
  std::vector<capnp::word> words(bytes.size() / sizeof(capnp::word));
  if (words.size() * sizeof(capnp::word) != bytes.size()) {
    return std::string("a message that is no whole number of words");
  }
  if (!words.empty()) std::memcpy(words.data(), bytes.data(), bytes.size());
  try {
    capnp::ReaderOptions limits;
    limits.traversalLimitInWords = 8 * words.size() + 1024;
    capnp::FlatArrayMessageReader reader(
        kj::ArrayPtr<const capnp::word>(words.data(), words.size()), limits);
    return get_message(reader.getRoot<wire::Message>());
  } catch (const kj::Exception& failure) {
    return std::string("a message that can't be read: ") + failure.getDescription().cStr();
  }
}

}  // namespace sleight::schema
