#include "clients/cli/save_command.h"

#include <cstdio>
#include <filesystem>
#include <memory>
#include <vector>

#include <fmt/format.h>

#include "clients/gallery_server/listed_files.h"
#include "clients/gallery_server/named_archives.h"
#include "clients/gallery_server/page_folder.h"
#include "clients/gallery_server/saved_gallery.h"
#include "clients/report/dumped_json.h"
#include "clients/service_client/service_call.h"
#include "clients/terminal/interruption.h"
#include "clients/terminal/output.h"
#include "clients/terminal/progress_printer.h"
#include "common/base/error.h"
#include "common/base/version.h"
#include "common/json/value.h"
#include "common/rpc/client.h"

namespace sleight::cli {
namespace {

std::vector<gallery::SavedArchive> read_archives(const std::vector<std::string>& paths) {
  const gallery::ListedFiles listed = gallery::listed_files(paths);
  for (const gallery::ListedFiles::LeftOut& left : listed.left_out)
    fmt::print(stderr, "left out: {}: {}\n", left.name, left.reason);
  std::vector<gallery::SavedArchive> archives;
  std::vector<base::Error> faults;
  for (const auto& [path, name] : listed.files) {
    terminal::ProgressPrinter printer("reading " + path, stderr);
    const gallery::Snapshot::Options options{.progress = [&](std::uint64_t done, std::uint64_t of) {
      terminal::Interruption::check();
      printer.say(fmt::format("{} of {} animations", done, of));
    }};
    try {
      archives.push_back(
          {.name = name, .snapshot = std::make_shared<const gallery::Snapshot>(path, options)});
      printer.clear();
    } catch (const base::Error& error) {
      printer.clear();
      if (error.exit_code() == base::ExitCode::interrupted) throw;
      faults.push_back(error);
    }
  }
  // If no archive can be read, the first fault is thrown below and not printed here.
  const std::size_t thrown = archives.empty() && !faults.empty() ? 1 : 0;
  for (std::size_t i = thrown; i < faults.size(); ++i)
    fmt::print(stderr, "left out: {}\n", faults[i].what());
  if (thrown != 0) throw base::Error(faults.front());
  if (archives.empty()) {
    throw base::Error(base::ExitCode::usage,
                      "no archive (*.h5) found; subfolders are not searched");
  }
  return archives;
}

/// Fetches the archives of jobs. If a job has no archive, fetches its committed results.
void fetch_jobs(const gallery::NamedArchives& named) {
  for (const gallery::NamedArchives::Job& job : named.jobs()) {
    service_client::with_service(named.service(), [&](rpc::Client& client) {
      const terminal::Interruption interruption([&client] { client.interrupt(); });
      try {
        client.fetch_file({.job = job.id, .kind = rpc::FetchKind::archive}, job.path);
      } catch (const rpc::RefusedError&) {
        client.fetch_file({.job = job.id, .kind = rpc::FetchKind::so_far}, job.path);
      }
      if (terminal::Interruption::requested())
        throw base::Error(base::ExitCode::interrupted, "interrupted");
      return 0;
    });
  }
}

}  // namespace

int save_archives(const CommandOptions& options, const std::function<std::string()>& service_called,
                  const analysis::Rules& rules) {
  return terminal::with_results([&] {
    const gallery::NamedArchives named(options.paths, service_called);
    fetch_jobs(named);
    const terminal::Interruption interruption;
    std::vector<gallery::SavedArchive> archives = read_archives(named.paths());
    terminal::ProgressPrinter printer("saving " + options.save, stderr);
    const gallery::SaveOptions save{.folder = options.save,
                                    .page = gallery::saved_page_folder(),
                                    .version = std::string(base::version()),
                                    .progress = [&](std::size_t done, std::size_t of) {
                                      terminal::Interruption::check();
                                      printer.say(fmt::format("{} of {} files", done, of));
                                    }};
    const auto save_readable = [&] {
      for (;;) {
        try {
          return save_gallery(archives, save, rules);
        } catch (const gallery::UnreadableArchive& error) {
          printer.clear();
          if (archives.size() == 1) throw;
          fmt::print(stderr, "left out: {}\n", error.what());
          archives.erase(archives.begin() + static_cast<std::ptrdiff_t>(error.number()));
        }
      }
    };
    const std::uint64_t bytes = save_readable();
    std::size_t animations = 0;
    for (const gallery::SavedArchive& archive : archives)
      animations += archive.snapshot->index().entries.size();
    printer.clear();
    constexpr double k_megabyte = 1e6;
    if (options.json) {
      const json::Value json{
          {"folder", options.save}, {"animations", animations}, {"bytes", bytes}};
      fmt::print("{}\n", report::dumped(json));
    } else {
      fmt::print("{}: {} animations, {:.1f} MB; open {}, or publish the folder on any web server\n",
                 options.save, animations, static_cast<double>(bytes) / k_megabyte,
                 (std::filesystem::path(options.save) / "index.html").string());
    }
    return static_cast<int>(base::ExitCode::ok);
  });
}

}  // namespace sleight::cli
