#include "tests/attacks/odd_values.h"

#include <algorithm>
#include <limits>
#include <string_view>

#include "common/access/token_text.h"

namespace sleight::attack {
namespace {

constexpr std::string_view k_texts[] = {
    "",
    "a",
    "../../../../../../etc/passwd",
    "/etc/passwd",
    "..",
    "jobs/1/../../../x",
    "\x1b[2J\x1b]0;owned\x07",
    "line\nanother line\r\n\t\v",
    "\xff\xfe\xc0\xaf\xed\xa0\x80",
    "%s%n%x{}{0}",
    "'; DROP TABLE job; --",
    "\"},{\"call\":\"stop\"",
    "17",
    "-1",
    "18446744073709551616",
    "\xe2\x80\xae\xe2\x80\x8b\xf3\xa0\x81\xa1",
};

constexpr char k_dear_request[] = R"([world]
name = "ball_2d"
[sampler]
method = "metropolis_hastings"
chains = 65536
seed = 1
iterations_per_scan = 1000
[stop]
scans = 1000000
)";

std::string repeated(std::string_view part, std::size_t bytes) {
  std::string text;
  for (std::size_t i = 0; i < bytes / part.size(); ++i)
    text += part;
  return text;
}

}  // namespace

std::string random_bytes(Dice& dice, std::size_t size) {
  std::string bytes(size, '\0');
  for (char& c : bytes)
    c = static_cast<char>(dice.bits());
  return bytes;
}

std::uint64_t odd_number(Dice& dice) {
  switch (dice.below(6)) {
    case 0:
      return dice.below(3);
    case 1:
      return (std::uint64_t{1} << dice.below(64)) - 1;
    case 2:
      return std::uint64_t{1} << dice.below(64);
    case 3:
      return std::numeric_limits<std::uint64_t>::max() - dice.below(3);
    case 4:
      return dice.below(1000);
    default:
      return dice.bits();
  }
}

double odd_real(Dice& dice) {
  using Limits = std::numeric_limits<double>;
  const double values[] = {0.0,
                           -0.0,
                           Limits::infinity(),
                           -Limits::infinity(),
                           Limits::max(),
                           Limits::denorm_min(),
                           Limits::quiet_NaN(),
                           -1.0,
                           1e300,
                           0.5,
                           9007199254740993.0,
                           dice.uniform()};
  return values[dice.below(std::size(values))];
}

std::uint64_t far_id(Dice& dice) {
  return dice.one_in(8) ? 0 : dice.bits() | 0x0101010101010101U;
}

std::string odd_text(Dice& dice, std::size_t bytes_max) {
  if (dice.one_in(1000)) return std::string(dice.one_in(2) ? bytes_max : bytes_max / 2, 'x');
  if (dice.one_in(20)) return std::string(dice.below(std::min<std::size_t>(bytes_max, 2000)), 'y');
  if (dice.one_in(6)) return random_bytes(dice, dice.below(80));
  return std::string(k_texts[dice.below(std::size(k_texts))]);
}

std::string odd_request(Dice& dice, std::size_t bytes_max) {
  const std::size_t bytes =
      dice.one_in(100) ? bytes_max : std::min<std::size_t>(bytes_max, 1 + dice.below(3000));
  switch (dice.below(9)) {
    case 0:
      return "a = " + std::string(bytes, '[');
    case 1:
      return "a = " + repeated("{a=", bytes);
    case 2:
      return repeated("a.", bytes).append("a = 1");
    case 3:
      return repeated("[a.", 3) + repeated("a.", bytes).append("a]");
    case 4:
      return repeated("[[a]]\n", bytes);
    case 5:
      return k_dear_request;
    case 6:
      return "a = \"" + std::string(bytes, 'x');
    case 7:
      return repeated("k = 1\n", bytes);
    default:
      return odd_text(dice, bytes_max);
  }
}

std::string wrong_token(Dice& dice, const std::string& real) {
  const auto drawn = [&](std::string id) {
    access::Token token{.id = std::move(id), .secret = {}};
    for (std::byte& byte : token.secret)
      byte = static_cast<std::byte>(dice.bits());
    return access::text_of(token);
  };
  std::string changed = real;
  switch (dice.below(9)) {
    case 0:
      // The real token's id, another secret, and a valid checksum.
      return drawn(real.substr(access::k_token_prefix.size(), access::k_token_id_characters));
    case 1:
      return drawn("0123456789");
    case 2: {
      char& c = changed[dice.below(changed.size())];
      c = c == 'q' ? 'r' : 'q';
      return changed;
    }
    case 3:
      return changed.substr(0, dice.below(changed.size()));
    case 4:
      return changed + changed;
    case 5:
      return changed.substr(1) + "\n";
    case 6:
      return std::string(access::k_token_characters, static_cast<char>(dice.bits()));
    case 7:
      return std::string(dice.one_in(10) ? 1U << 20U : 2000U, 'a');
    default:
      return odd_text(dice, 4000);
  }
}

}  // namespace sleight::attack
