#include "clients/cli/diagnose_command.h"

#include <fmt/format.h>

#include "clients/analysis/diagnosis_report.h"
#include "clients/report/dumped_json.h"
#include "common/archive/remote/remote_source.h"
#include "common/base/error.h"
#include "common/json/value.h"

namespace sleight::cli {

int diagnose_archive(const std::string& path, bool json, const analysis::Rules& rules) {
  const analysis::Diagnosis diagnosis = diagnosis_of(*archive::remote::open_remote(path), rules);
  if (json) {
    fmt::print("{}\n", report::dumped(as_json(path, diagnosis)));
  } else {
    fmt::print("{}", for_people(path, diagnosis));
  }
  return static_cast<int>(diagnosis.mixed() ? base::ExitCode::ok : base::ExitCode::not_mixed);
}

}  // namespace sleight::cli
