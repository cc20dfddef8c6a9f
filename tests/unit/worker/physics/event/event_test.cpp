// Goal: events are ordered by tick, then by kind, lower id, higher id and feature (event.h), and
// k_no_event comes last. Method: compare pairs of keys. A pair is equal up to one field, differs in
// that field, and has the opposite order in all later fields.
#include "worker/physics/event/event.h"

#include <gtest/gtest.h>

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
