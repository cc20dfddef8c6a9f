#include "clients/cli/failure_counts.h"

#include <nlohmann/json.hpp>

namespace sleight::cli {

nlohmann::ordered_json failures_json(const plan::FailureCounts& failures) {
  nlohmann::ordered_json json{{"total", failures.total()}};
  for (std::size_t kind = 0; kind < plan::k_failure_kinds; ++kind) {
    if (failures.by_kind[kind] > 0)
      json[std::string(plan::k_failure_names[kind])] = failures.by_kind[kind];
  }
  return json;
}

}  // namespace sleight::cli
