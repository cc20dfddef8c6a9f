#include "common/plan/failure.h"

#include <fmt/format.h>

namespace sleight::plan {

std::string to_string(const FailureCounts& counts) {
  std::string text;
  for (std::size_t kind = 0; kind < k_failure_kinds; ++kind) {
    if (counts.by_kind[kind] == 0) continue;
    text += fmt::format("{}{} {}", text.empty() ? "" : ", ", k_failure_names[kind],
                        counts.by_kind[kind]);
  }
  return text;
}

}  // namespace sleight::plan
