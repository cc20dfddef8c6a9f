#include "clients/cli/diagnose_command.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "clients/cli/diagnosis_report.h"
#include "clients/cli/opened_archive.h"
#include "common/base/error.h"

namespace sleight::cli {

int diagnose_archive(const std::string& path, bool json, const Rules& rules) {
  return with_archive(path, [&](const archive::Source& source) {
    const Diagnosis diagnosis = diagnosis_of(source, rules);
    if (json) {
      fmt::print("{}\n", dumped(as_json(path, diagnosis)));
    } else {
      fmt::print("{}", for_people(path, diagnosis));
    }
    return static_cast<int>(diagnosis.mixed() ? base::ExitCode::ok : base::ExitCode::not_mixed);
  });
}

}  // namespace sleight::cli
