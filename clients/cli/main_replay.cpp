#include "clients/cli/main_direct.h"

#include <fmt/format.h>

#include <optional>

#include "clients/cli/main_worlds.h"
#include "common/base/error.h"
#include "common/base/file_system.h"
#include "common/base/version.h"
#include "common/failure_file/failure_file.h"
#include "common/json/value.h"
#include "common/request/document.h"
#include "worker/run/catalogue.h"

namespace sleight::programs {
namespace {

failure_file::FailureFile read_file(const std::string& path) {
  auto read = failure_file::read(base::read_text_file(path, request::k_request_bytes_max), path);
  if (!read) throw base::Error(base::ExitCode::bad_request, request::to_string(read.error()));
  return std::move(read).value();
}

std::string verdict(const failure_file::FailureFile& file, const plan::FailurePointer& now) {
  const plan::SimulationFailure& then = file.failed.failure;
  if (now == nullptr) {
    return file.program_version == base::version()
               ? "The simulation succeeds, although this same version recorded the failure: either "
                 "the file was changed, or the simulation is not deterministic."
               : "The simulation succeeds in this version.";
  }
  if (*now == then) return "The simulation fails again, in the same way.";
  return fmt::format("The simulation fails in another way: {}: {}", plan::name_of(now->kind),
                     now->message);
}

void print(const failure_file::FailureFile& file, const run::SimulationEnd& end) {
  const plan::SimulationFailure& then = file.failed.failure;
  fmt::print("chain {}, replica {}, scan {}, recorded by sleight {}; this is sleight {}\n",
             file.replica.chain.value, file.replica.replica.value, file.failed.scan.value,
             file.program_version, base::version());
  fmt::print("Recorded failure: {}: {}\n", plan::name_of(then.kind), then.message);
  fmt::print("{}\n", verdict(file, end.failure));
  if (end.failure == nullptr)
    fmt::print("log p_w {:.6g}, log p_c {:.6g}\n", end.log_prior, end.log_constraint);
}

void print_json(const failure_file::FailureFile& file, const run::SimulationEnd& end) {
  const plan::SimulationFailure& then = file.failed.failure;
  json::Value json{{"chain", file.replica.chain.value},
                   {"replica", file.replica.replica.value},
                   {"scan", file.failed.scan.value},
                   {"recorded_by", file.program_version},
                   {"version", base::version()},
                   {"recorded_kind", plan::name_of(then.kind)},
                   {"recorded_message", then.message},
                   {"fails", end.failure != nullptr},
                   {"same", end.failure != nullptr && *end.failure == then}};
  if (end.failure != nullptr) {
    json["kind"] = plan::name_of(end.failure->kind);
    json["message"] = end.failure->message;
  } else {
    json["log_prior"] = end.log_prior;
    json["log_constraint"] = end.log_constraint;
  }
  fmt::print("{}\n", json.dump(2));
}

}  // namespace

int replay(const std::string& path, bool json) {
  const failure_file::FailureFile file = read_file(path);
  const run::Catalogue catalogue = worlds_of_program();
  const auto request = request::read_request(file.request_text, path, catalogue.bindings());
  if (!request) {
    throw base::Error(base::ExitCode::bad_request, request::to_string(request.error().front()));
  }
  const std::optional<run::SimulationEnd> end =
      catalogue.world_of(request.value()).simulate(request.value(), file.failed.failure.state);
  if (!end) {
    throw base::Error(
        base::ExitCode::bad_request,
        fmt::format("{}: 'state' is not a valid state of world '{}' with this request", path,
                    request.value().world));
  }
  if (json) {
    print_json(file, *end);
  } else {
    print(file, *end);
  }
  return static_cast<int>(end->failure == nullptr ? base::ExitCode::ok
                                                  : base::ExitCode::simulation_failed);
}

}  // namespace sleight::programs
