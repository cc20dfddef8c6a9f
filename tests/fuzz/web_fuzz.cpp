// Goal: no bytes from a peer make the gallery's server crash, hang, exceed its memory limit, or
// answer an unauthorized peer. Method: let libFuzzer create inputs. The first byte of an input
// defines how the other bytes are split into pieces. The connection receives these pieces. Pass the
// pieces through the parser, the guard and the answers in memory. Compare the results with those of
// a second reader (tests/unit/clients/web/checked_exchange.h lists the checks). CMakeLists.txt
// beside this file explains how to replay a failure.
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
