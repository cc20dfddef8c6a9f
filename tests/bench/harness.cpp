#include "tests/bench/harness.h"

#include <fmt/format.h>

namespace sleight::bench {
namespace {

// A global variable, because Google Benchmark can't report a failure to main().
bool wrong = false;

}  // namespace

void verify(benchmark::State& state, std::uint64_t hash, std::uint64_t expected) {
  state.SetLabel(fmt::format("hash {:016x}", hash));
  if (hash == expected) return;
  wrong = true;
  state.SkipWithError(
      fmt::format("wrong result: hash {:#018x}, expected {:#018x}", hash, expected).c_str());
}

bool any_wrong() {
  return wrong;
}

}  // namespace sleight::bench
