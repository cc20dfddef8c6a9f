// Goal: no bytes that a peer sends make the gallery's server crash, hang, hold more than it may or
// answer one that was not let in. Method: libFuzzer; an input is a connection's bytes, behind a
// first one that says in which pieces they come. They go through parser, guard and answers as in
// the server, in memory, and what comes of them is compared with a second reader's
// (tests/unit/clients/web/checked_exchange.h says what is checked).
// CMakeLists.txt beside this file says how to replay a failure.
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "tests/unit/clients/web/checked_exchange.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const std::string_view bytes(reinterpret_cast<const char*>(data + 1), size - 1);
  sleight::web::testing::checked_exchange(bytes, 1U + data[0]);
  return 0;
}
