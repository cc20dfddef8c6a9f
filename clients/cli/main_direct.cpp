#include "clients/cli/main_direct.h"

#include <fmt/format.h>

#include "clients/cli/main_worlds.h"
#include "common/base/clock.h"
#include "common/base/cores.h"
#include "common/base/error.h"
#include "service/coordinator/local_crew.h"
#include "service/coordinator/stop_signal.h"
#include "worker/sampling/block_runner.h"

namespace sleight::programs {
namespace {

constexpr int k_bad_request = static_cast<int>(base::ExitCode::bad_request);

int direct(const DirectArguments& arguments, cli::EndReport& end_report) {
  const cli::GivenRequest given = given_request(arguments);
  coordinator::catch_stop_signals();
  const run::Catalogue catalogue = worlds_of_program();
  if (arguments.print_request) return print_request(catalogue, given, arguments);
  const auto request = read_request(catalogue, given, arguments);
  if (!request) return k_bad_request;
  const std::size_t cores = base::cores_here();
  const base::SteadyClock clock;
  const auto worker = catalogue.world_of(*request).make_worker(*request, arguments.resources());
  const sampling::BlockRunner runner(*worker, clock);
  const std::size_t threads = arguments.threads > 0 ? arguments.threads : cores;
  coordinator::LocalCrew crew(runner, static_cast<std::uint32_t>(threads));
  const int code = run_and_report(*request, catalogue, arguments, crew, end_report);
  if (crew.is_busy()) leave_at_once(code);
  return code;
}

}  // namespace

int direct(const DirectArguments& arguments) {
  cli::EndReport end_report(arguments.end_report);
  return end_report.watch([&] { return direct(arguments, end_report); });
}

int check_request(const std::string& path, const std::vector<std::string>& sets) {
  if (path.empty())
    throw base::Error(base::ExitCode::usage,
                      "check: expected the name of a request, found an empty name");
  const run::Catalogue catalogue = worlds_of_program();
  DirectArguments arguments;
  arguments.request_path = path;
  arguments.sets = sets;
  const auto request =
      read_request(catalogue, cli::given_request(path, {}, std::nullopt), arguments);
  if (!request) return k_bad_request;
  fmt::print("{}", request::normalised_text(*request));
  return static_cast<int>(base::ExitCode::ok);
}

int print_keys(const std::string& world) {
  for (const request::WorldBinding& binding : worlds_of_program().bindings()) {
    if (world.empty()) {
      fmt::print("{}  {}\n", binding.name, binding.summary);
    } else if (binding.name == world) {
      fmt::print("{}", request::key_table(binding));
      return static_cast<int>(base::ExitCode::ok);
    }
  }
  if (world.empty()) return static_cast<int>(base::ExitCode::ok);
  throw base::Error(base::ExitCode::usage,
                    fmt::format("no world '{}'; to list the worlds, run `sleight keys`", world));
}

}  // namespace sleight::programs
