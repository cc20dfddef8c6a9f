#include "clients/analysis/failure_counts.h"

namespace sleight::analysis {

json::Value failures_json(const plan::FailureCounts& failures) {
  json::Value json{{"total", failures.total()}};
  for (std::size_t kind = 0; kind < plan::k_failure_kinds; ++kind) {
    if (failures.by_kind[kind] > 0)
      json[std::string(plan::k_failure_names[kind])] = failures.by_kind[kind];
  }
  return json;
}

}  // namespace sleight::analysis
