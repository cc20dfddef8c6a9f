// The batch program `sleight-batch` runs one request on the ranks of an MPI job. Rank 0 coordinates
// and computes; the other ranks compute. Without mpirun there is one rank, and MPI isn't started.
#include <fmt/format.h>
#include <mpi.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <optional>
#include <sstream>
#include <string>
#include <thread>

#include "clients/cli/end_with_mpirun.h"
#include "clients/cli/main_run.h"
#include "clients/cli/main_worlds.h"
#include "clients/cli/results_version.h"
#include "clients/terminal/output.h"
#include "common/base/check.h"
#include "common/base/clock.h"
#include "common/base/error.h"
#include "common/logging/log.h"
#include "service/coordinator/derive.h"
#include "service/coordinator/local_crew.h"
#include "service/coordinator/mpi/mpi_crew.h"
#include "service/coordinator/stop_signal.h"
#include "worker/run/mpi/mpi_worker.h"
#include "worker/sampling/block_runner.h"

namespace sleight::programs {
namespace {

/// Returns this process's rank, as mpirun or srun set it. Returns nothing if there is no MPI job.
std::optional<std::string> rank_by_environment() {
  for (const char* name : {"OMPI_COMM_WORLD_RANK", "PMIX_RANK"}) {
    if (const char* rank = std::getenv(name)) return rank;
  }
  return std::nullopt;
}

bool started_by_mpirun() {
  return rank_by_environment().has_value();
}

schema::Hello hello_of(const request::DirectionRequest& request) {
  return {.results_version = std::string(results_version()),
          .identity = coordinator::run_identity(request),
          .threads = 1};
}

/// Broadcasts from rank 0. Rank 0 may first wait until a person has typed the request. Meanwhile
/// the other ranks sleep. In MPI_Bcast, they wouldn't sleep.
void broadcast(void* data, std::uint64_t count, MPI_Datatype type) {
  MPI_Request request = MPI_REQUEST_NULL;
  MPI_Ibcast(data, static_cast<int>(count), type, 0, MPI_COMM_WORLD, &request);
  for (int is_done = 0; is_done == 0;) {
    MPI_Test(&request, &is_done, MPI_STATUS_IGNORE);
    if (is_done == 0) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
}

std::string as_rank_0_has_it(std::string text) {
  std::uint64_t bytes = text.size();
  broadcast(&bytes, 1, MPI_UINT64_T);
  text.resize(bytes);
  broadcast(text.data(), bytes, MPI_CHAR);
  return text;
}

/// Returns rank 0's request on all ranks, because the file or standard input may be missing on
/// other ranks. All ranks must call as_rank_0_has_it() at the same point.
cli::GivenRequest as_rank_0_has_it(const cli::GivenRequest& given) {
  return {.name = as_rank_0_has_it(given.name), .text = as_rank_0_has_it(given.text)};
}

struct Rank0End {
  int code = 0;
  bool all_have_left = true;  ///< all other ranks have exited
};

Rank0End run_rank_0(const DirectArguments& arguments, bool with_mpi, cli::EndReport& end_report) {
  cli::GivenRequest given = given_request(arguments);
  if (with_mpi) given = as_rank_0_has_it(given);
  coordinator::catch_stop_signals();
  const run::Catalogue catalogue = worlds_of_program();
  if (arguments.print_request) return {.code = print_request(catalogue, given, arguments)};
  const auto request = read_request(catalogue, given, arguments);
  if (!request) return {.code = static_cast<int>(base::ExitCode::bad_request)};
  const base::SteadyClock clock;
  const auto worker = catalogue.world_of(*request).make_worker(*request, arguments.resources());
  const sampling::BlockRunner runner(*worker, clock);
  if (!with_mpi) {
    coordinator::LocalCrew crew(runner, 1);
    const int code = run_and_report(*request, catalogue, arguments, crew, end_report);
    if (crew.is_busy()) leave_at_once(code);
    return {.code = code};
  }
  coordinator::MpiCrew crew(runner, clock, 1, hello_of(*request));
  const int code = run_and_report(*request, catalogue, arguments, crew, end_report);
  const bool all_have_left = crew.dismiss();
  if (crew.is_busy()) {
    std::fflush(nullptr);
    MPI_Abort(MPI_COMM_WORLD, code);
  }
  return {.code = code, .all_have_left = all_have_left};
}

void run_other_rank(DirectArguments arguments) {
  // All ranks receive signals, but only rank 0 acts on them.
  coordinator::ignore_stop_signals();
  arguments.errors_elsewhere = true;
  const cli::GivenRequest given = as_rank_0_has_it(cli::GivenRequest());
  if (arguments.print_request) return;
  const run::Catalogue catalogue = worlds_of_program();
  const base::SteadyClock clock;
  const auto request = read_request(catalogue, given, arguments);
  if (!request) {
    run::refuse(given.name + " has errors on this rank");
    return;
  }
  const auto worker = catalogue.world_of(*request).make_worker(*request, arguments.resources());
  const sampling::BlockRunner runner(*worker, clock);
  run::serve(runner, hello_of(*request));
}

std::string name_of_rank(int rank) {
  return fmt::format("sleight-batch, rank {}", rank);
}

/// Runs this rank and returns the job's exit code. Exceptions never pass MPI.
int run_ranks(const DirectArguments& arguments, cli::EndReport& end_report, int* argc,
              char*** argv) {
  int provided = 0;
  MPI_Init_thread(argc, argv, MPI_THREAD_FUNNELED, &provided);
  CHECK_GE(provided, MPI_THREAD_FUNNELED);
  int rank = 0;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  if (rank != 0) {
    try {
      run_other_rank(arguments);
    } catch (const base::Error& error) {
      if (error.exit_code() == base::ExitCode::bug) report_failure(name_of_rank(rank));
      run::refuse(error.what());
    } catch (const std::exception& error) {
      report_failure(name_of_rank(rank));
      run::refuse(error.what());
    }
    MPI_Finalize();
    return 0;
  }
  try {
    bool all_have_left = true;
    const int code = end_report.watch([&] {
      return terminal::with_results([&] {
        const Rank0End end = run_rank_0(arguments, true, end_report);
        all_have_left = end.all_have_left;
        return end.code;
      });
    });
    if (!all_have_left)
      logging::warn(
          "some ranks do not answer; all work is stored, and the job ends without these ranks");
    if (!all_have_left || code == static_cast<int>(base::ExitCode::bad_request)) {
      std::fflush(nullptr);
      MPI_Abort(MPI_COMM_WORLD, code);
    }
    MPI_Finalize();
    return code;
  } catch (...) {
    const int code = report_failure("sleight-batch");
    std::fflush(nullptr);
    MPI_Abort(MPI_COMM_WORLD, code);
    return code;
  }
}

/// Adds the rank and the launcher's command to bug reports.
void note_what_repeats_of_rank(int argc, char** argv) {
  const char* const ranks = std::getenv("OMPI_COMM_WORLD_SIZE");
  note_what_repeats(argc, argv, ranks == nullptr ? "" : fmt::format("mpirun -n {} ", ranks));
  if (const auto rank = rank_by_environment()) {
    base::add_repeat_note(fmt::format("rank {} of {}", *rank, ranks == nullptr ? "?" : ranks));
  }
}

int main_of(int argc, char** argv) {
  note_what_repeats_of_rank(argc, argv);
  CLI::App app;
  DirectArguments arguments;
  build_batch_app(app, arguments);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    std::ostringstream unheard;  // all ranks would print the same
    const bool speaks = rank_by_environment().value_or("0") == "0";
    const int code = speaks ? app.exit(error) : app.exit(error, unheard, unheard);
    return code == 0 ? 0 : static_cast<int>(base::ExitCode::usage);
  }
  logging::log_to_stderr("sleight-batch", false);
  try {
    // Every rank reports bugs. Only rank 0 reports how the session ended; ranks on other hosts
    // can't see the pipe.
    const bool is_rank_0 = rank_by_environment().value_or("0") == "0";
    cli::EndReport end_report(arguments.end_report, is_rank_0
                                                        ? cli::EndReport::Missing::is_an_error
                                                        : cli::EndReport::Missing::tells_nothing);
    if (started_by_mpirun()) return run_ranks(arguments, end_report, &argc, &argv);
    return end_report.watch([&] {
      return terminal::with_results([&] { return run_rank_0(arguments, false, end_report).code; });
    });
  } catch (...) {
    return report_failure("sleight-batch");
  }
}

}  // namespace
}  // namespace sleight::programs

int main(int argc, char** argv) {
  sleight::terminal::occupy_standard_streams();
  if (sleight::programs::started_by_mpirun()) sleight::cli::end_with_mpirun();
  return sleight::programs::main_of(argc, argv);
}
