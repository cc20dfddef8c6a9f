// Goal: the usual forms of a server's address are read, and malformed addresses are refused. An
// address without a port gets the default port.
#include "common/access/server_address.h"

#include <gtest/gtest.h>

namespace sleight::access {
namespace {

TEST(ServerAddressTest, IsReadAsPeopleWriteIt) {
  const auto text = [](const char* given) {
    const auto address = server_address_of(given);
    return address ? text_of(*address) : std::string("none");
  };
  EXPECT_EQ(text("render.example.org"), "render.example.org:7423");
  EXPECT_EQ(text("render.example.org:80"), "render.example.org:80");
  EXPECT_EQ(text("192.0.2.7:0"), "192.0.2.7:0");
  EXPECT_EQ(text("[2001:db8::7]"), "[2001:db8::7]:7423");
  EXPECT_EQ(text("[::1]:65535"), "[::1]:65535");
  EXPECT_EQ(text("my_host-1"), "my_host-1:7423");
}

TEST(ServerAddressTest, OddOnesAreRefused) {
  const std::string long_name(254, 'a');
  for (const std::string& given :
       {std::string(), std::string(":7423"), std::string("host:"), std::string("host:65536"),
        std::string("host:-1"), std::string("host:1x"), std::string("host:+1"), std::string("a/b"),
        std::string("../x"), std::string("a b"), std::string("a\nb"), std::string("a\0b", 3),
        std::string("-oProxy"), std::string("::1"), std::string("[::1"), std::string("[]:1"),
        std::string("[::1]x"), long_name})
    EXPECT_FALSE(server_address_of(given).has_value()) << given;
}

}  // namespace
}  // namespace sleight::access
