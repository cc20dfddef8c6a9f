#include "tests/unit/common/schema/wire/examples.h"

#include <algorithm>
#include <bit>
#include <iterator>
#include <limits>
#include <string>
#include <utility>

#include "tests/support/numbers.h"

namespace sleight::schema::wire::testing {
namespace {

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
         a.accepted == b.accepted && a.state == b.state && same(a.outcome, b.outcome) &&
         a.failures == b.failures && a.overlapping_starts == b.overlapping_starts &&
         same(a.method_values, b.method_values);
}

template <class T>
bool same_all(const std::vector<T>& a, const std::vector<T>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](const T& x, const T& y) { return same(x, y); });
}

bool same_results(const std::vector<plan::UnitResult>& all,
                  const std::vector<plan::UnitResult>& others) {
  return std::equal(all.begin(), all.end(), others.begin(), others.end(),
                    [](const plan::UnitResult& a, const plan::UnitResult& b) {
                      return same(a.unit, b.unit) && same_all(a.scans, b.scans) &&
                             a.state_after == b.state_after && same(a.cost_s, b.cost_s) &&
                             a.simulations == b.simulations && a.failed == b.failed;
                    });
}

bool same(const plan::Block& a, const plan::Block& b) {
  if (!same_all(a.members, b.members) || a.ladder.has_value() != b.ladder.has_value()) return false;
  if (!a.ladder) return true;
  const plan::LadderPart& x = *a.ladder;
  const plan::LadderPart& y = *b.ladder;
  return x.levels == y.levels && x.first_level == y.first_level &&
         same(x.inverse_temperatures, y.inverse_temperatures) &&
         same_all(x.proposal_scales, y.proposal_scales) && x.end_scan == y.end_scan &&
         x.scans_max == y.scans_max;
}

struct Same {
  bool operator()(const Hello& a, const Hello& b) const {
    return a.results_version == b.results_version && a.identity == b.identity &&
           a.threads == b.threads;
  }
  bool operator()(const Assignment& a, const Assignment& b) const {
    return a.epoch == b.epoch && a.assignment == b.assignment && same(a.block, b.block) &&
           a.states == b.states;
  }
  bool operator()(const Stop&, const Stop&) const { return true; }
  bool operator()(const Delivery& a, const Delivery& b) const {
    return a.epoch == b.epoch && a.assignment == b.assignment &&
           same_results(a.results, b.results) && a.cache == b.cache;
  }
  bool operator()(const Ping& a, const Ping& b) const { return a.epoch == b.epoch; }
  bool operator()(const Pong& a, const Pong& b) const {
    return a.epoch == b.epoch && a.assignments == b.assignments;
  }
  bool operator()(const Failure& a, const Failure& b) const { return a.reason == b.reason; }
  template <class A, class B>
  bool operator()(const A&, const B&) const {
    return false;
  }
};

constexpr std::uint32_t k_largest = std::numeric_limits<std::uint32_t>::max();
constexpr std::uint64_t k_largest_long = std::numeric_limits<std::uint64_t>::max();

plan::Unit example_unit(std::uint32_t scans) {
  return {.replica = {base::ChainId{k_largest}, base::ReplicaId{k_largest - 1}},
          .seed = k_largest_long - 1,
          .first_scan = base::ScanIndex{k_largest_long},
          .scans = scans,
          .starts = scans % 2 == 1,
          .lineage = k_largest_long,
          .inverse_temperatures = {0.1},
          .proposal_scales = {},
          .excursion = {}};
}

std::vector<Message> hellos_and_failures() {
  return {
      Hello{.results_version = "1.2+gabc", .identity = "[world]\nname = \"x\"\n", .threads = 64},
      Hello{},
      Hello{.results_version = std::string("a\0b", 3),
            .identity = std::string(300'000, 'i'),
            .threads = k_largest},
      Stop{},
      Ping{},
      Ping{.epoch = k_largest_long},
      Pong{},
      Pong{.epoch = 3, .assignments = {0, k_largest_long, 7, 7}},
      Pong{.epoch = 4, .assignments = std::vector<std::uint64_t>(100'000, 5)},
      Failure{.reason = "the disk is full"},
      Failure{},
      Failure{.reason = std::string("zero \0 within", 13)}};
}

std::vector<Message> assignments() {
  Assignment whole_ladder = example_assignment(300);
  whole_ladder.block.ladder->levels = 300;
  whole_ladder.block.ladder->first_level = 0;
  Assignment one_of_ladder = example_assignment(1);
  one_of_ladder.block.ladder->first_level = one_of_ladder.block.ladder->levels - 1;
  std::vector<Message> all{Assignment{.epoch = 1,
                                      .assignment = k_largest_long,
                                      .block = {.members = {example_unit(1)}, .ladder = {}},
                                      .states = {std::nullopt}},
                           // A missing state differs from an empty state.
                           Assignment{.epoch = k_largest_long,
                                      .assignment = 0,
                                      .block = {.members = {example_unit(2)}, .ladder = {}},
                                      .states = {base::Bytes{}}},
                           Assignment{.epoch = 2,
                                      .assignment = 1,
                                      .block = {.members = {example_unit(k_largest)}, .ladder = {}},
                                      .states = {base::Bytes(5'000'000, std::byte{3})}},
                           example_assignment(2), example_assignment(5), whole_ladder,
                           one_of_ladder};
  for (const double value : awkward_doubles()) {
    Assignment alone{.epoch = 5,
                     .assignment = 6,
                     .block = {.members = {example_unit(2)}, .ladder = {}},
                     .states = {base::Bytes{std::byte{0}}}};
    alone.block.members[0].inverse_temperatures = {value, 0};
    alone.block.members[0].proposal_scales = {value};
    alone.block.members[0].excursion = {0.5, value, 0};
    all.emplace_back(alone);
    Assignment part = example_assignment(3);
    part.block.ladder->inverse_temperatures = {0, value, value};
    part.block.ladder->proposal_scales = {{value, 1}, {}, {0.5, value, value}};
    all.emplace_back(part);
  }
  return all;
}

std::vector<Message> deliveries() {
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
  Delivery nothing = example_delivery({});
  nothing.cache = {};
  std::vector<Message> all{nothing,
                           example_delivery({}),
                           example_delivery({1}),
                           example_delivery({40}),
                           example_delivery({1, 7, 2, 1}),
                           example_delivery(std::vector<std::uint32_t>(300, 2)),
                           example_delivery({20'000})};
  Delivery other = example_delivery({});
  other.results = {bare, large, bare};
  all.emplace_back(other);
  for (const double value : awkward_doubles()) {
    Delivery costs = example_delivery({1, 1});
    costs.results[1].cost_s = value;
    all.emplace_back(costs);
  }
  return all;
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
  plan::UnitResult result{
      .unit = {.replica = {base::ChainId{k_largest}, base::ReplicaId{k_largest - 1}},
               .first_scan = base::ScanIndex{k_largest_long},
               .scans = scans},
      .scans = {},
      .failed = {},
      .state_after = base::Bytes(41, std::byte{0xa5}),
      .cost_s = 0.125,
      .simulations = k_largest_long - scans};
  const std::vector<double> awkward = awkward_doubles();
  for (std::uint32_t i = 0; i < scans; ++i) {
    result.scans.push_back({.log_prior = awkward[i % awkward.size()],
                            .log_constraint = awkward[(i + 4) % awkward.size()],
                            .satisfied = i % 2 == 1,
                            .lineage = k_largest_long - i,
                            .inverse_temperature = awkward[(i + 2) % awkward.size()],
                            .proposed = {i, 0, k_largest},
                            .accepted = {0, i},
                            .outcome = awkward,
                            .failures = {.by_kind = {i % 3 == 1 ? i : 0U, 0, 0, 0, 0, i % 3}},
                            .overlapping_starts = i % 4 == 0 ? k_largest_long : 0,
                            .method_values = i % 3 == 0 ? awkward : std::vector<double>{},
                            .state = base::Bytes(i % 9, std::byte{7})});
    if (i % 3 != 1 || result.failed.size() == plan::k_failed_told_max) continue;
    result.failed.push_back(
        {.scan = base::ScanIndex{k_largest_long - i},
         .failure = {.kind = static_cast<plan::FailureKind>(i % plan::k_failure_kinds),
                     .message = "ball 7 \u00e9",
                     .state = base::Bytes(i % 7, std::byte{9})}});
  }
  return result;
}

Delivery example_delivery(const std::vector<std::uint32_t>& scans) {
  Delivery delivery{.epoch = k_largest_long,
                    .assignment = k_largest_long - 1,
                    .results = {},
                    .cache = {.hits = 1,
                              .misses = k_largest_long,
                              .evictions = 3,
                              .bytes = 4,
                              .bytes_max = k_largest_long - 5}};
  for (std::uint32_t i = 0; i < scans.size(); ++i) {
    plan::UnitResult& result = delivery.results.emplace_back(example_result(scans[i]));
    result.unit.replica = {base::ChainId{7}, base::ReplicaId{i}};
    result.unit.first_scan.value -= i;
  }
  return delivery;
}

Assignment example_assignment(std::uint32_t members) {
  Assignment assignment{.epoch = 11, .assignment = 12, .block = {}, .states = {}};
  plan::LadderPart part{.levels = members + 4,
                        .first_level = 3,
                        .inverse_temperatures = {},
                        .proposal_scales = {},
                        .end_scan = k_largest_long,
                        .scans_max = k_largest};
  for (std::uint32_t i = 0; i < members; ++i) {
    plan::Unit unit = example_unit(1);
    unit.replica.replica = base::ReplicaId{i};
    unit.starts = i % 3 == 2;
    assignment.block.members.push_back(unit);
    plan::GivenState& state = assignment.states.emplace_back();
    if (i % 3 > 0) state = base::Bytes(i % 3 - 1, std::byte{9});
    part.inverse_temperatures.push_back(0.1 * i);
    part.proposal_scales.push_back(std::vector<double>(i % 3, 0.3 * i));
  }
  assignment.block.ladder = std::move(part);
  return assignment;
}

std::vector<Message> examples() {
  std::vector<Message> all;
  for (std::vector<Message>& some : std::vector{hellos_and_failures(), assignments(), deliveries()})
    std::ranges::move(some, std::back_inserter(all));
  return all;
}

bool same_bits(const Message& a, const Message& b) {
  return std::visit(Same{}, a, b);
}

}  // namespace sleight::schema::wire::testing
