#include "clients/cli/main_derive.h"

#include <fmt/format.h>

#include <filesystem>
#include <system_error>

#include "clients/cli/main_worlds.h"
#include "clients/cli/results_version.h"
#include "clients/terminal/progress_printer.h"
#include "common/base/clock.h"
#include "common/base/error.h"
#include "common/base/file_system.h"
#include "common/base/output_beside.h"
#include "common/json/value.h"
#include "common/request/direction_request.h"
#include "common/store/run_store.h"
#include "common/store/sessions.h"
#include "common/store/shared_database.h"
#include "service/coordinator/derive.h"
#include "service/coordinator/output_place.h"
#include "service/coordinator/stop_signal.h"
#include "service/coordinator/writing_words.h"
#include "worker/run/catalogue.h"

namespace sleight::programs {
namespace {

void refuse_what_is_no_run(const std::string& folder) {
  base::PosixFileSystem files;
  if (!files.exists(store::RunStore::database_path(folder))) {
    throw base::Error(fmt::format(
        "{}: not the folder of a run; a run with output ball.h5 has the folder ball.h5.run",
        folder));
  }
}

void refuse_unusable_output(const DeriveArguments& arguments,
                            const request::DirectionRequest& request) {
  base::PosixFileSystem files;
  coordinator::refuse_unusable_place(arguments.output, files);
  const std::string own = store::own_archive_of(arguments.folder);
  std::error_code ignored;
  if (!own.empty() && std::filesystem::weakly_canonical(own, ignored) ==
                          std::filesystem::weakly_canonical(arguments.output, ignored)) {
    throw base::Error(
        base::ExitCode::usage,
        fmt::format(
            "-o {}: the run itself writes this archive; choose another name, or resume the run",
            arguments.output));
  }
  if (files.exists(arguments.output))
    coordinator::refuse_foreign_file(arguments.output, coordinator::beginnings_of(request));
}

}  // namespace

int derive(const DeriveArguments& given) {
  DeriveArguments arguments = given;
  arguments.output = base::where_links_lead(given.output);
  std::string folder = arguments.folder;
  while (folder.size() > 1 && folder.ends_with('/'))
    folder.pop_back();
  refuse_what_is_no_run(folder);

  // Check the results version: another version might interpret the scans differently.
  const store::StoredRequest stored = store::stored_request_of(folder);
  if (stored.results_version != results_version()) {
    throw base::Error(
        base::ExitCode::conflict,
        fmt::format("{}: the stored results have version {} (sleight {}), but this program "
                    "computes version {}; use the sleight version that stored the results",
                    folder, stored.results_version, stored.program_version, results_version()));
  }
  const run::Catalogue catalogue = worlds_of_program();
  const auto read = request::read_request(stored.request_text, folder, catalogue.bindings());
  if (!read) {
    throw base::Error(fmt::format("{}: damaged run, can't read its request: {}", folder,
                                  request::to_string(read.error().front())));
  }
  const request::DirectionRequest& request = read.value();
  refuse_unusable_output({.folder = folder, .output = arguments.output, .json = arguments.json},
                         request);

  const run::WorldEntry& world = catalogue.world_of(request);
  const auto plan = run::make_plan(request, world);
  request::Cut cut = coordinator::committed_cut(folder, *plan);
  const auto reader = world.make_reader(request);
  const std::function<std::unique_ptr<plan::Plan>(const request::Cut&)> plan_of =
      [&](const request::Cut& at) { return run::make_plan(request, world, at); };
  base::PosixFileSystem files;
  std::string digest;
  if (cut.scans > 0 || cut.found > 0) {
    const base::SteadyClock clock;
    terminal::ProgressPrinter printer(request.world, stderr);
    coordinator::WritingWords words([&](const std::string& phase) { printer.say(phase); }, clock);
    coordinator::catch_stop_signals();
    try {
      digest = coordinator::derive_archive(
          {.request = request,
           .reader = *reader,
           .plan_of = plan_of,
           .files = files,
           .results_version = stored.results_version,
           .hear = [&](const archive::WritingProgress& now) { words.hear(now); }},
          folder, arguments.output, cut, &coordinator::stop_requested);
    } catch (const coordinator::DeriveStopped&) {
      printer.clear();
      throw base::Error(
          base::ExitCode::interrupted,
          fmt::format(
              "{}: interrupted before the archive was written; an existing file is unchanged",
              arguments.output));
    }
    printer.clear();
  }
  if (arguments.json) {
    const json::Value json{{"archive", digest.empty() ? "" : arguments.output},
                           {"chains", request.sampler.chains},
                           {"scans", cut.scans},
                           {"found", cut.found},
                           {"finished", plan->finished()},
                           {"digest", digest}};
    fmt::print("{}\n", json.dump(2));
  } else if (digest.empty()) {
    fmt::print("{}: no archive yet, because the run has no draws and no finds\n", folder);
  } else {
    fmt::print("{}: {} chain{} of {} scans, {} found, digest {}{}\n", arguments.output,
               request.sampler.chains, request.sampler.chains == 1 ? "" : "s", cut.scans, cut.found,
               digest, plan->finished() ? "" : "; the run has not finished");
  }
  return static_cast<int>(base::ExitCode::ok);
}

}  // namespace sleight::programs
