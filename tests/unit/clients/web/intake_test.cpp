// Goal: the server refuses bytes or reads the same requests from them as a second, simple reader.
// Method: send known bytes with known outcomes. Compare random and hostile requests with the second
// reader in checked_exchange.h. Check that the second reader refuses ambiguous bytes.
#include "clients/web/intake.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "tests/support/property.h"
#include "tests/unit/clients/web/checked_exchange.h"
#include "tests/unit/clients/web/random_request.h"

namespace sleight::web {
namespace {

using testing::checked_exchange;
using testing::k_limits;
using testing::k_secret;
using testing::Outcome;

std::string fields() {
  return fmt::format("Host: 127.0.0.1:7000\r\nCookie: sleight-7000={}\r\n", k_secret);
}
std::string get(const std::string& target) {
  return fmt::format("GET {} HTTP/1.1\r\n{}\r\n", target, fields());
}
std::string post(const std::string& more, const std::string& body) {
  return fmt::format(
      "POST /api/find HTTP/1.1\r\n{}Origin: http://127.0.0.1:7000\r\n"
      "Content-Type: application/json\r\n{}\r\n{}",
      fields(), more, body);
}

TEST(Intakes, TakeRequestsOneBehindAnother) {
  const std::string bytes = get("/a") + post("Content-Length: 2\r\n", "{}") + get("/b") +
                            post("Content-Length: 4\r\n", "abcd") + get("/c");
  for (std::size_t piece = 1; piece < 100; piece += 7) {
    const Outcome outcome = checked_exchange(bytes, piece);
    ASSERT_EQ(outcome.taken.size(), 5U);
    EXPECT_EQ(outcome.taken[0].passed.ask.path, "/a");
    EXPECT_EQ(outcome.taken[1].passed.ask.body, "{}");
    EXPECT_EQ(outcome.taken[2].passed.ask.path, "/b");
    EXPECT_EQ(outcome.taken[3].passed.ask.body, "abcd");
    EXPECT_EQ(outcome.taken[4].passed.ask.path, "/c");
    EXPECT_EQ(outcome.refused, 0U);
  }
}

TEST(Intakes, EndWhereTheyAreToldTo) {
  EXPECT_EQ(
      checked_exchange("GET / HTTP/1.1\r\nConnection: close\r\n" + fields() + "\r\n" + get("/"), 9)
          .taken.size(),
      1U);
  EXPECT_EQ(checked_exchange("GET / HTTP/1.0\r\n" + fields() + "\r\n" + get("/"), 9).taken.size(),
            1U);
}

TEST(Intakes, RefuseWhatHasTwoReadings) {
  const auto refused = [](const std::string& bytes) {
    const Outcome outcome = checked_exchange(bytes, 11);
    EXPECT_EQ(outcome.taken.size(), 0U) << bytes;
    return outcome.refused;
  };
  const std::string smuggled = "0\r\n\r\n" + get("/smuggled");
  for (const std::string more :
       {"Content-Length: 5\r\nTransfer-Encoding: chunked\r\n",
        "Transfer-Encoding: chunked\r\nContent-Length: 5\r\n",
        "Content-Length: 5\r\nContent-Length: 6\r\n", "Content-Length: 5\r\nContent-Length: 5\r\n",
        "Content-Length: 5, 5\r\n", "Content-Length: +5\r\n", "Content-Length: 0x5\r\n",
        "Content-Length: -5\r\n", "Transfer-Encoding : chunked\r\n",
        "Transfer-Encoding\r\n: chunked\r\n",
        "Transfer-Encoding:\x0b"
        "chunked\r\n",
        "Transfer-Encoding: chunked\r\nTransfer-Encoding: identity\r\n"}) {
    EXPECT_EQ(refused(post(more, smuggled)), 400U) << more;
  }
  for (const std::string more :
       {"chunked", "xchunked", "chunked, identity", "identity, chunked", ""})
    EXPECT_EQ(refused(post("Transfer-Encoding: " + more + "\r\n", smuggled)), 411U) << more;
  EXPECT_EQ(refused("GET /a HTTP/1.1\n" + fields() + "\n"), 400U);
  EXPECT_EQ(refused("GET /a HTTP/2.0\r\n" + fields() + "\r\n"), 400U);
  EXPECT_EQ(refused("GET  /a HTTP/1.1\r\n" + fields() + "\r\n"), 400U);
  EXPECT_EQ(refused("GET /a\r\n\r\n"), 400U);
  EXPECT_EQ(refused("\r\nGET /a HTTP/1.1\r\n" + fields() + "\r\n"), 400U);
  EXPECT_EQ(refused("\x16\x03\x01\x02\x00\x01"), 400U);
  EXPECT_EQ(refused("PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n"), 400U);
}

TEST(Intakes, RefuseWhatIsTooLong) {
  const auto refused = [](const std::string& bytes) {
    return checked_exchange(bytes, 500).refused;
  };
  const std::string more(k_limits.head_bytes_max, 'a');
  EXPECT_EQ(refused("GET /" + more), 431U);
  EXPECT_EQ(refused(more + more), 431U);
  EXPECT_EQ(refused("GET / HTTP/1.1\r\n" + fields() + "A: " + more), 431U);
  std::string many;
  while (many.size() < k_limits.head_bytes_max)
    many += "A:\r\n";
  EXPECT_EQ(refused("GET / HTTP/1.1\r\n" + fields() + many + "\r\n"), 431U);
  EXPECT_EQ(refused(get("/" + std::string(2048, 'a'))), 400U);

  const std::string longest(k_limits.body_bytes_max, 'b');
  const auto with_length = [](const std::string& body) {
    return post(fmt::format("Content-Length: {}\r\n", body.size()), body);
  };
  EXPECT_EQ(refused(with_length(longest)), 0U);
  EXPECT_EQ(refused(with_length(longest + "b")), 413U);
  EXPECT_EQ(refused(post("Content-Length: 999999999999999999\r\n", "")), 413U);
}

TEST(Intakes, KeepNoBodyBeforeTheGuardHasSpoken) {
  Keys keys{std::string(k_secret)};
  const Guard guard({.port = 7000}, keys);
  BodyBudget budget{.bytes_max = 1000};
  Intake intake(guard, k_limits, budget);
  std::string bytes = post("Content-Length: 900\r\n", std::string(100, 'a'));
  bytes.replace(bytes.find(k_secret), 1, "4");
  const auto give = [](Intake& to, const std::string& text) {
    ASSERT_EQ(to.step(), Step::more);
    const std::span<char> room = to.room();
    ASSERT_GE(room.size(), text.size());
    std::ranges::copy(text, room.begin());
    to.got(text.size());
  };
  give(intake, bytes);
  EXPECT_EQ(intake.step(), Step::refused);
  EXPECT_EQ(intake.refusal().status, 403U);
  EXPECT_TRUE(intake.refusal().is_json);
  EXPECT_EQ(budget.bytes, 0U);
}

// Each case tests about 50 random requests. tests/fuzz tests more requests.
TEST(Intakes, AgreeWithThePlainReaderOnAnything) {
  constexpr std::uint64_t k_seed = 27;
  std::size_t passed = 0;
  std::size_t refused = 0;
  const std::uint64_t cases = property::long_run() ? 21'000 : property::of_tier(200, 1'600);
  for (const std::uint64_t n : property::cases(cases)) {
    random::Stream stream({.seed = k_seed, .purpose = random::Purpose::prior}, n);
    for (int i = 0; i < 40; ++i) {
      const std::string bytes = testing::random_connection(stream);
      const Outcome outcome = checked_exchange(bytes, 1 + testing::below(stream, 300));
      passed += outcome.taken.size();
      if (outcome.refused != 0) ++refused;
    }
  }
  if (property::all_cases()) {
    EXPECT_GT(passed, 6 * cases);
    EXPECT_GT(refused, 6 * cases);
  }
  RecordProperty("passed", static_cast<int>(passed));
  RecordProperty("refused", static_cast<int>(refused));
}

TEST(Intakes, ThePlainReaderIsNoFriendOfSmugglers) {
  using testing::read_plainly;
  EXPECT_EQ(read_plainly(get("/")).size(), 1U);
  EXPECT_EQ(read_plainly(post("Content-Length: 2\r\n", "{}")).at(0).body, "{}");
  EXPECT_EQ(read_plainly(post("Content-Length: 2\r\n", "{")).size(), 0U);
  EXPECT_EQ(
      read_plainly(post("Content-Length: 2\r\nTransfer-Encoding: chunked\r\n", "0\r\n\r\n")).size(),
      0U);
  EXPECT_EQ(read_plainly(post("Content-Length: 2\r\nContent-Length: 2\r\n", "{}")).size(), 0U);
  EXPECT_EQ(read_plainly(post("Transfer-Encoding: chunked\r\n", "0\r\n\r\n")).size(), 0U);
  EXPECT_EQ(read_plainly("GET / HTTP/1.1\n\n").size(), 0U);
}

}  // namespace
}  // namespace sleight::web
