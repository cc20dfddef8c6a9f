// Goal: attempt names are read back as they were written, and invalid names and orders are
// rejected.
#include <gtest/gtest.h>

#include <string>

#include "service/backend/backend.h"

namespace sleight::backend {
namespace {

const AttemptName k_name{.daemon = "abcdefgh12", .job = 17, .epoch = 3};

TEST(AttemptNames, AreReadAsTheyAreWritten) {
  EXPECT_EQ(to_text(k_name), "sleight:abcdefgh12:17:3");
  EXPECT_EQ(attempt_name_of(to_text(k_name)), k_name);
  const AttemptName largest{.daemon = std::string(32, 'z'), .job = ~0ULL, .epoch = ~0ULL};
  EXPECT_EQ(attempt_name_of(to_text(largest)), largest);
}

TEST(AttemptNames, AreNothingElse) {
  for (const char* text :
       {"", "sleight", "sleight:", "sleight:abcdefgh:17",
        "sleight:abcdefgh:17:", "sleight:abcdefgh::3", "sleight::17:3", "sleight:short:17:3",
        "sleight:ABCDEFGH:17:3", "sleight:abcdefgh:017:3", "sleight:abcdefgh:17:0",
        "sleight:abcdefgh:17:3 ", " sleight:abcdefgh:17:3", "sleight:abcdefgh:17:3:4",
        "sleight:abcdefgh:-1:3", "sleight:abcdefgh:+1:3", "sleight:abcdefgh:18446744073709551616:3",
        "sleight:abcdefghijklmnopqrstuvwxyz1234567:1:1", "other:abcdefgh:17:3"})
    EXPECT_FALSE(attempt_name_of(text)) << text;
}

TEST(AttemptNames, OrdersAreChecked) {
  // Method: check a valid order, then orders that have one error each.
  const Order right{.name = k_name, .folder = "/jobs/it's 17", .command = {"/bin/true", "a\nb"}};
  EXPECT_NO_THROW(check_order(right));
  const auto is_wrong = [&right](auto&& change) {
    Order order = right;
    change(order);
    EXPECT_THROW(check_order(order), base::Error);
  };
  is_wrong([](Order& order) { order.name.daemon = "x"; });
  is_wrong([](Order& order) { order.name.epoch = 0; });
  is_wrong([](Order& order) { order.folder = "jobs/17"; });
  is_wrong([](Order& order) { order.folder = "/jobs/1\n7"; });
  is_wrong([](Order& order) { order.command.clear(); });
  is_wrong([](Order& order) { order.command = {"true"}; });
  is_wrong([](Order& order) { order.label = "a\tb"; });
  is_wrong([](Order& order) { order.options["account"] = "a\nb"; });
}

}  // namespace
}  // namespace sleight::backend
