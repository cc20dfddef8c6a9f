#include "common/schema/wire/wire.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/unit/common/schema/wire/examples.h"

namespace sleight::schema::wire {
namespace {

using ::testing::HasSubstr;

TEST(Messages, ComeBackBitForBit) {
  // Goal: if a message of any kind is encoded and decoded, it stays equal bit for bit.
  const std::vector<Message> all = testing::examples();
  for (std::size_t i = 0; i < all.size(); ++i) {
    const base::Result<Message, std::string> back = decode(encode(all[i]));
    ASSERT_TRUE(back.ok()) << "example " << i << ": " << back.error();
    EXPECT_TRUE(testing::same_bits(back.value(), all[i])) << "example " << i;
  }
}

/// Returns true if the comparison notices `change`. Fails if the comparison reports a difference
/// before the change.
template <class M, class Change>
bool is_seen(const M& example, const Change& change) {
  M changed = example;
  EXPECT_TRUE(testing::same_bits(changed, example));
  change(changed);
  return !testing::same_bits(changed, example);
}

TEST(Messages, ComparerSeesOneBit) {
  // Goal: the comparison of messages notices every difference. Method: change each field as little
  // as possible, for example the sign of a zero.
  Delivery zeros = testing::example_delivery({1});
  zeros.results[0].scans[0].outcome = {0.0};
  EXPECT_TRUE(is_seen(zeros, [](Delivery& d) { d.results[0].scans[0].outcome = {-0.0}; }));

  using DeliveryChange = void (*)(Delivery&);
  const DeliveryChange delivery_changes[] = {
      [](Delivery& d) { --d.epoch; },
      [](Delivery& d) { --d.assignment; },
      [](Delivery& d) { ++d.cache.hits; },
      [](Delivery& d) { d.results.pop_back(); },
      [](Delivery& d) { ++d.results[1].unit.replica.chain.value; },
      [](Delivery& d) { ++d.results[1].unit.replica.replica.value; },
      [](Delivery& d) { ++d.results[1].unit.first_scan.value; },
      [](Delivery& d) { ++d.results[1].unit.scans; },
      [](Delivery& d) { d.results[1].state_after.back() ^= std::byte{1}; },
      [](Delivery& d) { d.results[1].cost_s = -d.results[1].cost_s; },
      [](Delivery& d) { ++d.results[1].simulations; },
      [](Delivery& d) { d.results[1].scans[0].state = {std::byte{1}}; },
      [](Delivery& d) { d.results[1].scans[0].satisfied ^= true; },
      [](Delivery& d) { ++d.results[1].scans[0].lineage; },
      [](Delivery& d) { ++d.results[1].scans[0].accepted[1]; },
      [](Delivery& d) { ++d.results[1].scans[0].failures.by_kind[2]; },
      [](Delivery& d) { ++d.results[1].scans[0].overlapping_starts; },
      [](Delivery& d) { d.results[1].scans[0].method_values.pop_back(); },
      [](Delivery& d) { d.results[1].scans[0].method_values[1] = 0.25; },
      [](Delivery& d) { d.results[1].failed.push_back({}); },
  };
  for (const DeliveryChange change : delivery_changes)
    EXPECT_TRUE(is_seen(testing::example_delivery({1, 1}), change));

  using AssignmentChange = void (*)(Assignment&);
  const AssignmentChange assignment_changes[] = {
      [](Assignment& a) { ++a.epoch; },
      [](Assignment& a) { ++a.assignment; },
      [](Assignment& a) { a.states[0] = base::Bytes{}; },
      [](Assignment& a) { a.states[1].reset(); },
      [](Assignment& a) { a.block.members.pop_back(); },
      [](Assignment& a) { a.block.members[2].starts ^= true; },
      [](Assignment& a) { a.block.members[2].excursion = {0}; },
      [](Assignment& a) { a.block.ladder.reset(); },
      [](Assignment& a) { ++a.block.ladder->levels; },
      [](Assignment& a) { ++a.block.ladder->first_level; },
      [](Assignment& a) { a.block.ladder->inverse_temperatures[0] = -0.0; },
      [](Assignment& a) { a.block.ladder->proposal_scales[0] = {1}; },
      [](Assignment& a) { --a.block.ladder->end_scan; },
      [](Assignment& a) { --a.block.ladder->scans_max; },
  };
  for (const AssignmentChange change : assignment_changes)
    EXPECT_TRUE(is_seen(testing::example_assignment(3), change));

  EXPECT_TRUE(is_seen(Hello{}, [](Hello& hello) { ++hello.threads; }));
  EXPECT_TRUE(is_seen(Ping{}, [](Ping& ping) { ++ping.epoch; }));
  EXPECT_TRUE(is_seen(Pong{}, [](Pong& pong) { ++pong.epoch; }));
  EXPECT_TRUE(is_seen(Pong{}, [](Pong& pong) { pong.assignments = {0}; }));
  EXPECT_FALSE(testing::same_bits(Stop{}, Failure{}));
}

TEST(Messages, EncodingIsAFunctionOfTheMessage) {
  // Goal: encoding a message twice gives the same bytes.
  for (const Message& message : testing::examples())
    EXPECT_EQ(encode(message), encode(message));
}

std::string refusal(const Message& message) {
  const auto back = decode(encode(message));
  return back.ok() ? "" : back.error();
}

TEST(Messages, ResultsKeepOfTheirUnitsWhatTheyAreKnownBy) {
  // Goal: a result's unit arrives with its replica, its first scan and the number of scan records,
  // even if the unit states another number of scans. The unit's other fields are not sent.
  for (const std::uint32_t claimed : {3U, 0U, 2U, 4U, 0xffffffffU}) {
    Delivery delivery = testing::example_delivery({3});
    plan::Unit& unit = delivery.results[0].unit;
    const plan::Unit known = unit;
    unit.scans = claimed;
    unit.seed = 4;
    unit.starts = true;
    unit.lineage = 5;
    unit.inverse_temperatures = {0.1, 0.2, 0.3};
    unit.proposal_scales = {2};
    unit.excursion = {0};
    const auto back = decode(encode(delivery));
    ASSERT_TRUE(back.ok()) << back.error();
    const plan::UnitResult& result = std::get<Delivery>(back.value()).results.at(0);
    EXPECT_EQ(result.unit, known) << claimed;
    EXPECT_EQ(result.scans.size(), 3U);
  }
}

TEST(Messages, ResultWithoutScansIsRefused) {
  // Goal: a delivery is refused if one of its results has no scans. A delivery without results is
  // accepted.
  EXPECT_THAT(refusal(testing::example_delivery({0})), HasSubstr("no scans"));
  EXPECT_THAT(refusal(testing::example_delivery({2, 0, 1})), HasSubstr("no scans"));
  EXPECT_EQ(refusal(testing::example_delivery({})), "");
}

TEST(Messages, HelloOfNoThreadsIsRefused) {
  // Goal: if a worker announces 0 threads, it is refused.
  EXPECT_THAT(refusal(Hello{.results_version = "1", .identity = "i", .threads = 0}),
              HasSubstr("0 threads"));
}

TEST(Messages, AssignmentsThatDoNotFitAreRefused) {
  // Goal: if the parts of an assignment contradict each other, it is refused. Method: break one
  // rule at a time, first in a valid single unit, then in a valid part of a ladder. Use numbers
  // that overflow, too.
  const plan::Unit unit{.replica = {}, .seed = 0, .first_scan = {}, .scans = 1};
  const Assignment alone{
      .epoch = 1, .assignment = 2, .block = {.members = {unit}, .ladder = {}}, .states = {{}}};
  const Assignment part = testing::example_assignment(3);
  ASSERT_EQ(refusal(alone), "");
  ASSERT_EQ(refusal(part), "");
  const auto expect_refused = [](Assignment broken, const char* what, const auto& change) {
    change(broken);
    EXPECT_THAT(refusal(broken), HasSubstr("inconsistent parts")) << what;
  };

  expect_refused(alone, "no members", [](Assignment& a) {
    a.block.members.clear();
    a.states.clear();
  });
  expect_refused(alone, "two members without a part", [](Assignment& a) {
    a.block.members.push_back(a.block.members[0]);
    a.states.emplace_back();
  });
  expect_refused(alone, "no scans", [](Assignment& a) { a.block.members[0].scans = 0; });
  expect_refused(alone, "neither one temperature nor one a scan", [](Assignment& a) {
    a.block.members[0].scans = 3;
    a.block.members[0].inverse_temperatures = {0.1, 0.2};
  });
  expect_refused(alone, "no temperatures",
                 [](Assignment& a) { a.block.members[0].inverse_temperatures.clear(); });

  expect_refused(part, "no members", [](Assignment& a) {
    a.block.members.clear();
    a.states.clear();
  });
  expect_refused(part, "no members at no levels", [](Assignment& a) {
    a.block.members.clear();
    a.states.clear();
    a.block.ladder->inverse_temperatures.clear();
    a.block.ladder->proposal_scales.clear();
  });
  expect_refused(part, "a member too few", [](Assignment& a) {
    a.block.members.pop_back();
    a.states.pop_back();
  });
  expect_refused(part, "a member too many", [](Assignment& a) {
    a.block.members.push_back(a.block.members[0]);
    a.states.emplace_back();
  });
  expect_refused(part, "a temperature too many",
                 [](Assignment& a) { a.block.ladder->inverse_temperatures.push_back(1); });
  expect_refused(part, "scales too few",
                 [](Assignment& a) { a.block.ladder->proposal_scales.pop_back(); });
  for (const std::uint32_t scans : {0U, 2U, 0xffffffffU}) {
    expect_refused(part, "not one scan", [&](Assignment& a) { a.block.members[1].scans = scans; });
  }
  expect_refused(part, "fewer levels than members",
                 [](Assignment& a) { a.block.ladder->levels = 2; });
  expect_refused(part, "no levels", [](Assignment& a) { a.block.ladder->levels = 0; });
  for (const std::uint32_t first_level : {5U, 6U, 7U, 0xfffffffdU, 0xfffffffeU, 0xffffffffU}) {
    expect_refused(part, "levels beyond the ladder's",
                   [&](Assignment& a) { a.block.ladder->first_level = first_level; });
  }
  for (const std::uint32_t first_level : {0U, 4U}) {
    Assignment fits = part;
    fits.block.ladder->first_level = first_level;
    EXPECT_EQ(refusal(fits), "") << first_level;
  }
}

TEST(Messages, PiecesOfNothingAreRefused) {
  // Goal: a message is refused if it is empty, or if it has one byte too many or too few.
  EXPECT_FALSE(decode({}).ok());
  const base::Bytes whole = encode(testing::example_delivery({2}));
  EXPECT_FALSE(decode(base::BytesView(whole).first(whole.size() - 1)).ok());
  base::Bytes longer = whole;
  longer.push_back(std::byte{0});
  EXPECT_FALSE(decode(longer).ok());
}

TEST(Messages, AreReadAtAnyAddress) {
  // Goal: a message can be decoded at any address, without alignment.
  const Message message = testing::example_delivery({3});
  const base::Bytes bytes = encode(message);
  for (std::size_t offset = 0; offset < 8; ++offset) {
    base::Bytes moved(offset);
    moved.insert(moved.end(), bytes.begin(), bytes.end());
    const auto back = decode(base::BytesView(moved).subspan(offset));
    ASSERT_TRUE(back.ok());
    EXPECT_TRUE(testing::same_bits(back.value(), message));
  }
}

}  // namespace
}  // namespace sleight::schema::wire
