#include "tests/unit/common/schema/examples.h"

#include <algorithm>
#include <bit>
#include <limits>
#include <string>

namespace sleight::schema::testing {
namespace {

constexpr double k_infinity = std::numeric_limits<double>::infinity();

bool same(double a, double b) {
  return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b);
}

bool same(const std::vector<double>& a, const std::vector<double>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](double x, double y) { return same(x, y); });
}

bool same(const plan::Unit& a, const plan::Unit& b) {
  return a.replica == b.replica && a.first_scan == b.first_scan && a.scans == b.scans &&
         a.starts == b.starts && a.lineage == b.lineage &&
         same(a.inverse_temperatures, b.inverse_temperatures) &&
         same(a.proposal_scales, b.proposal_scales) && same(a.excursion, b.excursion);
}

bool same(const plan::ScanRecord& a, const plan::ScanRecord& b) {
  return same(a.log_prior, b.log_prior) && same(a.log_constraint, b.log_constraint) &&
         a.satisfied == b.satisfied && a.lineage == b.lineage &&
         same(a.inverse_temperature, b.inverse_temperature) && a.proposed == b.proposed &&
         a.accepted == b.accepted && a.state == b.state && same(a.outcome, b.outcome);
}

/// Compares two messages of one kind.
struct Same {
  bool operator()(const Hello& a, const Hello& b) const {
    return a.program_version == b.program_version && a.identity == b.identity;
  }
  bool operator()(const Assignment& a, const Assignment& b) const {
    return same(a.unit, b.unit) && a.state == b.state;
  }
  bool operator()(const Stop&, const Stop&) const { return true; }
  bool operator()(const plan::UnitResult& a, const plan::UnitResult& b) const {
    return same(a.unit, b.unit) && a.state_after == b.state_after && same(a.cost_s, b.cost_s) &&
           std::equal(a.scans.begin(), a.scans.end(), b.scans.begin(), b.scans.end(),
                      [](const auto& x, const auto& y) { return same(x, y); });
  }
  bool operator()(const Failure& a, const Failure& b) const { return a.reason == b.reason; }
  template <class A, class B>
  bool operator()(const A&, const B&) const {
    return false;
  }
};

plan::Unit example_unit(std::uint32_t scans) {
  return {.replica = {base::ChainId{std::numeric_limits<std::uint32_t>::max()},
                      base::ReplicaId{std::numeric_limits<std::uint32_t>::max() - 1}},
          .first_scan = base::ScanIndex{std::numeric_limits<std::uint64_t>::max()},
          .scans = scans,
          .starts = scans % 2 == 1,
          .lineage = std::numeric_limits<std::uint64_t>::max(),
          .inverse_temperatures = {0.1},
          .proposal_scales = {},
          .excursion = {}};
}

}  // namespace

std::vector<double> awkward_doubles() {
  return {std::bit_cast<double>(std::uint64_t{0x7ff8'0000'0000'0000}),
          std::bit_cast<double>(std::uint64_t{0xfff8'1234'5678'9abc}),
          std::bit_cast<double>(std::uint64_t{0x7ff0'0000'0000'0001}),
          k_infinity,
          -k_infinity,
          0.0,
          -0.0,
          std::numeric_limits<double>::denorm_min(),
          -std::numeric_limits<double>::max(),
          0.1};
}

plan::UnitResult example_result(std::uint32_t scans) {
  plan::UnitResult result{.unit = example_unit(scans),
                          .scans = {},
                          .state_after = base::Bytes(41, std::byte{0xa5}),
                          .cost_s = 0.125};
  const std::vector<double> awkward = awkward_doubles();
  for (std::uint32_t i = 0; i < scans; ++i) {
    result.scans.push_back({.log_prior = awkward[i % awkward.size()],
                            .log_constraint = awkward[(i + 4) % awkward.size()],
                            .satisfied = i % 2 == 1,
                            .lineage = std::numeric_limits<std::uint64_t>::max() - i,
                            .inverse_temperature = awkward[(i + 2) % awkward.size()],
                            .proposed = {i, 0, std::numeric_limits<std::uint32_t>::max()},
                            .accepted = {0, i},
                            .outcome = awkward,
                            .state = base::Bytes(i % 9, std::byte{7})});
  }
  return result;
}

std::vector<Message> examples() {
  plan::UnitResult bare = example_result(3);
  bare.state_after.clear();
  for (plan::ScanRecord& scan : bare.scans) {
    scan.proposed.clear();
    scan.accepted.clear();
    scan.outcome.clear();
    scan.state.clear();
  }
  plan::UnitResult large = example_result(2);
  large.state_after.assign(5'000'000, std::byte{1});
  large.scans[1].outcome.assign(300'000, -0.0);
  std::vector<Message> all{
      Hello{.program_version = "1.2+gabc", .identity = "[world]\nname = \"x\"\n"},
      Hello{},
      Hello{.program_version = std::string("a\0b", 3), .identity = std::string(300'000, 'i')},
      Assignment{.unit = example_unit(1), .state = {}},
      Assignment{.unit = example_unit(std::numeric_limits<std::uint32_t>::max()),
                 .state = base::Bytes(5'000'000, std::byte{3})},
      Stop{},
      Failure{.reason = "the disk is full"},
      Failure{},
      Failure{.reason = std::string("zero \0 within", 13)},
      example_result(0),
      example_result(1),
      example_result(40),
      bare,
      large,
      example_result(20'000)};
  for (const double value : awkward_doubles()) {
    Assignment assignment{.unit = example_unit(2), .state = {std::byte{0}}};
    assignment.unit.inverse_temperatures = {value, 0};
    assignment.unit.proposal_scales = {value};
    assignment.unit.excursion = {0.5, value, 0};
    all.emplace_back(assignment);
  }
  return all;
}

bool same_bits(const Message& a, const Message& b) {
  return std::visit(Same{}, a, b);
}

}  // namespace sleight::schema::testing
