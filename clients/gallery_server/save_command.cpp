#include "clients/gallery_server/save_command.h"

#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "clients/cli/dumped_json.h"
#include "clients/cli/interruption.h"
#include "clients/cli/output.h"
#include "clients/cli/progress_printer.h"
#include "clients/cli/service_call.h"
#include "clients/gallery_server/listed_files.h"
#include "clients/gallery_server/named_archives.h"
#include "clients/gallery_server/page_folder.h"
#include "clients/gallery_server/saved_gallery.h"
#include "common/base/error.h"
#include "common/base/version.h"
#include "common/json/value.h"
#include "common/rpc/client.h"

namespace sleight::gallery {
namespace {

std::vector<SavedArchive> read_archives(const std::vector<std::string>& paths) {
  const ListedFiles listed = listed_files(paths);
  for (const ListedFiles::LeftOut& left : listed.left_out)
    fmt::print(stderr, "left out: {}: {}\n", left.name, left.reason);
  std::vector<SavedArchive> archives;
  std::vector<base::Error> faults;
  for (const auto& [path, name] : listed.files) {
    cli::ProgressPrinter printer("reading " + path, stderr);
    const Snapshot::Options options{.progress = [&](std::uint64_t done, std::uint64_t of) {
      cli::Interruption::check();
      printer.say(fmt::format("{} of {} animations", done, of));
    }};
    try {
      archives.push_back(
          {.name = name, .snapshot = std::make_shared<const Snapshot>(path, options)});
      printer.clear();
    } catch (const base::Error& error) {
      printer.clear();
      if (error.exit_code() == base::ExitCode::interrupted) throw;
      faults.push_back(error);
    }
  }
  // The first one ends the program where nothing is left, and is said by that.
  const std::size_t thrown = archives.empty() && !faults.empty() ? 1 : 0;
  for (std::size_t i = thrown; i < faults.size(); ++i)
    fmt::print(stderr, "left out: {}\n", faults[i].what());
  if (thrown != 0) throw base::Error(faults.front());
  if (archives.empty()) {
    throw base::Error(
        base::ExitCode::usage,
        "there is no archive (*.h5) in what was named; folders below are not searched");
  }
  return archives;
}

/// Brings the archives of jobs here: a job that has none of its own yet gives what it committed.
void fetch_jobs(const NamedArchives& named) {
  for (const NamedArchives::Job& job : named.jobs()) {
    cli::with_service(named.service(), [&](rpc::Client& client) {
      const cli::Interrupts interrupts(&client);
      try {
        client.fetch_file({.job = job.id, .kind = rpc::FetchKind::archive}, job.path);
      } catch (const rpc::RefusedError&) {
        client.fetch_file({.job = job.id, .kind = rpc::FetchKind::so_far}, job.path);
      }
      if (cli::Interrupts::requested())
        throw base::Error(base::ExitCode::interrupted, "interrupted");
      return 0;
    });
  }
}

}  // namespace

int save_archives(const CommandOptions& options, const std::function<std::string()>& service_called,
                  const cli::Rules& rules) {
  return cli::with_results([&] {
    const NamedArchives named(options.paths, service_called);
    fetch_jobs(named);
    const cli::Interruption interruption;
    std::vector<SavedArchive> archives = read_archives(named.paths());
    cli::ProgressPrinter printer("saving " + options.save, stderr);
    const SaveOptions save{.folder = options.save,
                           .page = saved_page_folder(),
                           .version = std::string(base::version()),
                           .progress = [&](std::size_t done, std::size_t of) {
                             cli::Interruption::check();
                             printer.say(fmt::format("{} of {} files", done, of));
                           }};
    const auto save_readable = [&] {
      for (;;) {
        try {
          return save_gallery(archives, save, rules);
        } catch (const UnreadableArchive& error) {
          printer.clear();
          if (archives.size() == 1) throw;
          fmt::print(stderr, "left out: {}\n", error.what());
          archives.erase(archives.begin() + static_cast<std::ptrdiff_t>(error.number()));
        }
      }
    };
    const std::uint64_t bytes = save_readable();
    std::size_t animations = 0;
    for (const SavedArchive& archive : archives)
      animations += archive.snapshot->index().entries.size();
    printer.clear();
    constexpr double k_megabyte = 1e6;
    if (options.json) {
      const json::Value json{
          {"folder", options.save}, {"animations", animations}, {"bytes", bytes}};
      fmt::print("{}\n", cli::dumped(json));
    } else {
      fmt::print("{}: {} animations, {:.1f} MB; open {}, or put the folder on any web server\n",
                 options.save, animations, static_cast<double>(bytes) / k_megabyte,
                 (std::filesystem::path(options.save) / "index.html").string());
    }
    return static_cast<int>(base::ExitCode::ok);
  });
}

}  // namespace sleight::gallery
