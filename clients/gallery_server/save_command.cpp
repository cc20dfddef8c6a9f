#include "clients/gallery_server/save_command.h"

#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "clients/cli/interruption.h"
#include "clients/cli/opened_archive.h"
#include "clients/cli/output.h"
#include "clients/cli/progress_printer.h"
#include "clients/gallery_server/listed_files.h"
#include "clients/gallery_server/page_folder.h"
#include "clients/gallery_server/saved_gallery.h"
#include "common/base/error.h"
#include "common/base/version.h"

namespace sleight::gallery {
namespace {

std::vector<SavedArchive> read_archives(const std::vector<std::string>& paths) {
  const ListedFiles listed = listed_files(paths);
  for (const ListedFiles::LeftOut& left : listed.left_out)
    fmt::print(stderr, "left out: {}: {}\n", left.name, left.reason);
  std::vector<SavedArchive> archives;
  std::optional<base::Error> first;
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
      if (!first) first = error;
      fmt::print(stderr, "left out: {}\n", error.what());
    }
  }
  if (archives.empty() && first) throw base::Error(*first);
  if (archives.empty())
    throw base::Error(base::ExitCode::usage, "there is no archive in what was named");
  return archives;
}

}  // namespace

int save_archives(const CommandOptions& options, const cli::Rules& rules) {
  return cli::with_results([&] {
    const cli::Interruption interruption;
    const std::vector<SavedArchive> archives = read_archives(options.paths);
    std::size_t animations = 0;
    for (const SavedArchive& archive : archives)
      animations += archive.snapshot->index().entries.size();
    cli::ProgressPrinter printer("saving " + options.save, stderr);
    const std::uint64_t bytes =
        save_gallery(archives,
                     {.folder = options.save,
                      .page = saved_page_folder(),
                      .version = std::string(base::version()),
                      .progress =
                          [&](std::size_t done, std::size_t of) {
                            cli::Interruption::check();
                            printer.say(fmt::format("{} of {} files", done, of));
                          }},
                     rules);
    printer.clear();
    constexpr double k_megabyte = 1e6;
    if (options.json) {
      const nlohmann::ordered_json json{
          {"folder", options.save}, {"animations", animations}, {"bytes", bytes}};
      fmt::print("{}\n", cli::dumped(json));
    } else {
      fmt::print(
          "{0}: {1} animations, {2:.1f} MB; open {0}/index.html, or put the folder on any web "
          "server\n",
          options.save, animations, static_cast<double>(bytes) / k_megabyte);
    }
    return static_cast<int>(base::ExitCode::ok);
  });
}

}  // namespace sleight::gallery
