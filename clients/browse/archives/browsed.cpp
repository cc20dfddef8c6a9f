#include "clients/browse/archives/browsed.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <set>
#include <utility>

#include "clients/browse/archives/kept_animations.h"
#include "clients/browse/query.h"
#include "clients/terminal/progress_printer.h"
#include "common/archive/format.h"
#include "common/archive/remote/remote_source.h"
#include "common/base/error.h"

namespace sleight::browse {
namespace {

/// Reading is reported on stderr only if it takes longer than this.
constexpr double k_silent_s = 1;

class ReadingPrinter {
 public:
  explicit ReadingPrinter(const std::string& path) : printer_("reading " + path, stderr) {}
  ~ReadingPrinter() { printer_.clear(); }
  void show(std::uint64_t read, std::uint64_t of) {
    const double elapsed_s =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - began_).count();
    if (elapsed_s < k_silent_s || read == 0) return;
    const double left_s = elapsed_s / static_cast<double>(read) * static_cast<double>(of - read);
    printer_.say(fmt::format("{} of {} animations, {:.0f} s left", read, of, std::ceil(left_s)));
  }

 private:
  terminal::ProgressPrinter printer_;
  std::chrono::steady_clock::time_point began_ = std::chrono::steady_clock::now();
};

browse::Condition parsed(const std::string& text, const char* option,
                         const BrowsedArchive& archive) {
  auto condition = browse::parse_query(text, archive.index.scene, archive.index.numbers);
  if (condition) return std::move(condition).value();
  throw base::Error(base::ExitCode::usage, fmt::format("{} for {}: {}", option, archive.path,
                                                       browse::with_mark(condition.error(), text)));
}

browse::Condition wanted_of(const QueryOptions& asked, const BrowsedArchive& archive) {
  browse::AllOf wanted;
  for (const std::string& text : asked.select)
    wanted.parts.push_back(parsed(text, "--select", archive));
  for (const std::string& text : asked.where)
    wanted.parts.push_back(parsed(text, "--where", archive));
  for (const std::string& text : asked.in)
    wanted.parts.push_back(parsed(text, "--in", archive));
  for (const std::string& text : asked.not_in) {
    browse::Not no;
    no.part.push_back(parsed(text, "--not", archive));
    wanted.parts.push_back({std::move(no)});
  }
  return {std::move(wanted)};
}

}  // namespace

std::size_t Browsed::animations() const {
  std::size_t sum = 0;
  for (const BrowsedArchive& archive : archives)
    sum += archive.index.entries.size();
  return sum;
}

browse::ReadIndex read_index(const archive::Source& source, const std::string& path,
                             const IndexingOptions& options) {
  std::optional<KeptIndex> kept = options.earlier == nullptr ? kept_index(path) : std::nullopt;
  const bool is_of_this_file = kept && options.file && kept->of == *options.file;
  auto read = browse::read_index(source, {.earlier = kept ? &kept->index : options.earlier,
                                          .of_this_file = is_of_this_file ? &kept->index : nullptr,
                                          .beginning_max = options.beginning_max,
                                          .progress = options.progress});
  if (!read) {
    throw base::Error(base::ExitCode::bad_archive, fmt::format("{}: {}", path, read.error()));
  }
  browse::ReadIndex found = std::move(read).value();
  if (options.file && !is_of_this_file && !found.is_beginning)
    keep_index(path, *options.file, found.index);
  return found;
}

browse::Index index_of(const archive::Source& source, const std::string& path,
                       const std::optional<FileState>& file) {
  ReadingPrinter printer(path);
  return read_index(
             source, path,
             {.file = file,
              .progress = [&](std::uint64_t done, std::uint64_t of) { printer.show(done, of); }})
      .index;
}

Browsed browse_archives(const std::vector<std::string>& paths) {
  Browsed browsed;
  std::optional<base::Error> first;
  for (const std::string& path : paths) {
    const auto leave_out = [&](const base::Error& error) {
      if (!first) first = error;
      const std::string prefix = path + ": ";
      std::string reason = error.what();
      if (reason.starts_with(prefix)) reason.erase(0, prefix.size());
      browsed.left_out.push_back({.path = path, .reason = std::move(reason)});
    };
    try {
      // Get the file's state before opening, so that the index of a replaced file isn't cached as
      // the new file's.
      const std::optional<FileState> file = state_of_file(path);
      browsed.archives.push_back(
          {.path = path, .index = index_of(*archive::remote::open_remote(path), path, file)});
    } catch (const base::Error& error) {
      if (error.exit_code() == base::ExitCode::interrupted) throw;
      leave_out(error);
    } catch (const std::bad_alloc&) {
      leave_out({base::ExitCode::environment,
                 fmt::format("{}: too little memory to browse this archive", path)});
    }
  }
  if (browsed.archives.empty() && first) throw base::Error(*first);
  leave_out_twice(browsed);
  return browsed;
}

void leave_out_twice(Browsed& browsed) {
  std::set<browse::AnimationName> seen;
  for (BrowsedArchive& archive : browsed.archives) {
    archive.twice += std::erase_if(archive.index.entries, [&](const browse::Entry& entry) {
      return !seen.insert(entry.name).second;
    });
  }
}

std::vector<Picked> picked(Browsed& browsed, const QueryOptions& asked) {
  // Build all conditions before erasing archives, because erasing moves other archives.
  std::vector<browse::Condition> wanted;
  std::optional<base::Error> first;
  std::erase_if(browsed.archives, [&](const BrowsedArchive& archive) {
    try {
      wanted.push_back(wanted_of(asked, archive));
      return false;
    } catch (const base::Error& error) {
      if (!first) first = error;
      browsed.left_out.push_back({.path = archive.path, .reason = error.what()});
      return true;
    }
  });
  if (browsed.archives.empty() && first) throw base::Error(*first);
  std::vector<Picked> all;
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    const BrowsedArchive& archive = browsed.archives[i];
    for (const std::size_t entry : browse::find(wanted[i], archive.index))
      all.push_back({.archive = &archive, .entry = &archive.index.entries[entry]});
  }
  return all;
}

std::string name_among(const Browsed& browsed, const browse::AnimationName& name) {
  const bool is_one_run = std::ranges::all_of(browsed.archives, [&](const BrowsedArchive& archive) {
    return archive.index.run_id == browsed.archives.front().index.run_id;
  });
  return is_one_run ? browse::short_text(name) : browse::long_text(name);
}

void say_what_is_missing(const Browsed& browsed) {
  for (const LeftOut& left : browsed.left_out)
    fmt::print(stderr, "left out: {}: {}\n", left.path, left.reason);
  for (const BrowsedArchive& archive : browsed.archives) {
    if (archive.twice > 0)
      fmt::print(stderr,
                 "{}: skipped {} animations, because an earlier archive on the command line "
                 "contains them too\n",
                 archive.path, archive.twice);
  }
}

std::string shown_number(double number) {
  return std::isnan(number) ? std::string() : fmt::format("{:.6g}", number);
}

}  // namespace sleight::browse
