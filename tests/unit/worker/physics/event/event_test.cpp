// Goal: events are ordered as event.h says: by tick, then kind, lower id, higher id, feature.
// Method: pairs of keys that agree up to one field and disagree, the other way round, in all later
// ones; the kinds in the order of the list; k_no_event behind the latest others.
#include "worker/physics/event/event.h"

#include <gtest/gtest.h>

#include <array>

namespace sleight::physics {
namespace {

TEST(EventOrder, is_decided_by_the_first_field_that_differs) {
  const EventKey base{
      .tick = Tick{10}, .kind = EventKind::collision, .lower = 20, .higher = 30, .feature = 40};
  for (int field = 0; field < 5; ++field) {
    EventKey earlier = base;
    if (field < 1) earlier.tick = Tick{9};
    if (field <= 1) earlier.kind = field == 1 ? EventKind::start : EventKind::sample;
    if (field <= 2) earlier.lower = field == 2 ? 19 : 21;
    if (field <= 3) earlier.higher = field == 3 ? 29 : 31;
    earlier.feature = field == 4 ? 39 : 41;
    EXPECT_LT(earlier, base) << "field " << field;
    EXPECT_GT(base, earlier) << "field " << field;
    EXPECT_NE(base, earlier) << "field " << field;
  }
  EXPECT_EQ(base <=> base, std::strong_ordering::equal);
}

TEST(EventOrder, of_kinds_is_that_of_the_list) {
  constexpr std::array k_kinds = {EventKind::update,    EventKind::control, EventKind::start,
                                  EventKind::collision, EventKind::mode,    EventKind::rest,
                                  EventKind::sample};
  for (std::size_t i = 1; i < k_kinds.size(); ++i) {
    const EventKey earlier{.tick = Tick{1}, .kind = k_kinds[i - 1], .lower = 9};
    const EventKey later{.tick = Tick{1}, .kind = k_kinds[i], .lower = 0};
    EXPECT_LT(earlier, later) << i;
  }
}

TEST(EventOrder, of_ids_is_unsigned_and_of_ticks_signed) {
  // Goal: no field is compared in the wrong type. Method: values on both sides of a sign bit.
  EXPECT_LT((EventKey{.tick = Tick{0}, .lower = 0x7fffffff}),
            (EventKey{.tick = Tick{0}, .lower = 0x80000000}));
  EXPECT_LT((EventKey{.tick = Tick{0}, .higher = 0x7fffffff}),
            (EventKey{.tick = Tick{0}, .higher = 0x80000000}));
  EXPECT_LT((EventKey{.tick = Tick{0}, .feature = 0x7fffffff}),
            (EventKey{.tick = Tick{0}, .feature = 0x80000000}));
  EXPECT_LT((EventKey{.tick = Tick{-1}}), (EventKey{.tick = Tick{0}}));
}

TEST(EventOrder, ends_with_no_event) {
  EXPECT_LT(EventKey{}, k_no_event);
  EXPECT_LT((EventKey{.tick = k_tick_max, .kind = EventKind::sample, .lower = UINT32_MAX}),
            k_no_event);
  EventKey last = k_no_event;
  last.feature = UINT32_MAX - 1;
  EXPECT_LT(last, k_no_event);
}

}  // namespace
}  // namespace sleight::physics
