#include "clients/cli/export_command.h"

#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iostream>
#include <nlohmann/json.hpp>
#include <span>
#include <string_view>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "clients/cli/animation_ids.h"
#include "clients/cli/exported_animations.h"
#include "clients/cli/opened_archive.h"
#include "clients/cli/output.h"
#include "clients/export/document.h"
#include "common/archive/kept_motions.h"
#include "common/archive/summary.h"
#include "common/base/error.h"

namespace sleight::cli {
namespace {

namespace fs = std::filesystem;

constexpr int k_ok = static_cast<int>(base::ExitCode::ok);
constexpr std::size_t k_run_letters = 8;
constexpr auto k_progress_every = std::chrono::seconds(1);

[[noreturn]] void refuse_usage(const std::string& reason) {
  throw base::Error(base::ExitCode::usage, reason);
}

[[noreturn]] void refuse_write(const std::string& path) {
  throw base::Error(fmt::format("{}: can't write it: {}", path,
                                errno != 0 ? std::strerror(errno) : "is the disk full?"));
}

/// A file of the output.
struct Written {
  std::string path;
  std::vector<std::string> ids;
  std::uint64_t bytes = 0;
};

bool is_file_of(const std::string& output, const std::string& format) {
  return output.ends_with("." + format);
}

/// What the options say by themselves, before any file is opened.
void check(const ExportAnimationsOptions& options) {
  const std::string& format = options.format;
  if (format != "glb" && format != "csv")
    refuse_usage(fmt::format("--format {}: not yet; glb and csv are written", format));
  if (format == "glb" && options.output.empty())
    refuse_usage("say where to with -o: a file OUT.glb, or a folder for a file each");
  if (format == "glb" && options.together && !is_file_of(options.output, format))
    refuse_usage(
        fmt::format("{}: --together makes one file; its name must end with .glb", options.output));
  if (format == "csv" && !options.output.empty() && !is_file_of(options.output, format))
    refuse_usage(fmt::format("{}: a table's name must end with .csv", options.output));
  if (format == "csv" && (options.together || options.fps))
    refuse_usage("--together and --fps are for --format glb");
  if (options.json && options.output.empty())
    refuse_usage("--json tells which files were written; name one with -o");
  // Also what is no number, which lies in no range and outside none.
  if (options.fps && !(*options.fps >= k_export_fps_min && *options.fps <= k_export_fps_max)) {
    refuse_usage(fmt::format("--fps {}: it must be from {} to {}", *options.fps, k_export_fps_min,
                             k_export_fps_max));
  }
}

/// Step one: which animations.
std::vector<AnimationId> choose(const archive::Source& source,
                                const ExportAnimationsOptions& options) {
  if (!options.ids.empty()) return animations_of(source, options.ids);
  std::vector<AnimationId> all = animation_ids(source);
  if (all.empty())
    throw base::Error(fmt::format("{}: it holds no animation; run more scans", source.name()));
  // A table grows by a line for each.
  if (all.size() > k_export_max && !options.all && options.format != "csv") {
    refuse_usage(
        fmt::format("{}: it holds {} animations, more than {}; name some with --ids, or give --all",
                    source.name(), all.size(), k_export_max));
  }
  return all;
}

/// A file of our making says so in its first words.
bool is_ours(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::string head(96, '\0');
  file.read(head.data(), static_cast<std::streamsize>(head.size()));
  return head.starts_with("glTF") && head.find("\"generator\":\"Sleight\"") != std::string::npos;
}

void refuse_others_file(const std::string& path, bool force) {
  std::error_code none;
  if (force || !fs::is_regular_file(path, none) || is_ours(path)) return;
  throw base::Error(
      base::ExitCode::conflict,
      fmt::format("{}: it is there already, and sleight did not make it, or can't tell; give "
                  "--force to replace it",
                  path));
}

void write_file(const std::string& place, const std::string& shown,
                const std::function<void(std::ostream&)>& write) {
  errno = 0;
  std::ofstream file(place, std::ios::binary);
  if (file) {
    write(file);
    file.close();
  }
  if (!file) refuse_write(shown);
}

/// Tells how far it is, now and then, where it takes long.
class Progress {
 public:
  explicit Progress(std::size_t all) : all_(all) {}
  void done(std::size_t count) {
    const auto now = std::chrono::steady_clock::now();
    if (now - told_ < k_progress_every || count == all_) return;
    told_ = now;
    fmt::print(stderr, "{} of {} animations\n", count, all_);
  }

 private:
  std::size_t all_;
  std::chrono::steady_clock::time_point told_ = std::chrono::steady_clock::now();
};

/// Makes the files of models. Runs in the child that reads the archive.
class GlbExport {
 public:
  GlbExport(const archive::Source& source, const ExportAnimationsOptions& options)
      : source_(source), options_(options), scene_(scene_of(source)), extras_(extras_of(source)) {}

  /// All as clips of one file. `place`: where to write.
  Written write_one(std::span<const AnimationId> ids, const std::string& place) {
    Progress progress(ids.size());
    gltf::Document document{.scene = scene_, .extras = extras_};
    Written written{.path = options_.output, .ids = {}};
    for (const AnimationId& id : ids) {
      document.clips.push_back(clip_of(source_, scene_, id));
      written.ids.push_back(id.text);
      progress.done(written.ids.size());
    }
    put(document, place, written);
    return written;
  }

  /// A file each, written in `beside` and then renamed into the output folder.
  std::vector<Written> write_each(std::span<const AnimationId> ids, const std::string& beside) {
    Progress progress(ids.size());
    const std::string run = run_letters(archive::summary_of(source_).run_id);
    const auto name_of = [&](const AnimationId& id) {
      return fmt::format("{}-{}.glb", run, id.text);
    };
    make_folder(options_.output);
    for (const AnimationId& id : ids)
      refuse_others_file(options_.output + "/" + name_of(id), options_.force);
    make_folder(beside);
    std::vector<Written> all;
    for (const AnimationId& id : ids) {
      gltf::Document document{.scene = scene_, .extras = extras_};
      document.clips.push_back(clip_of(source_, scene_, id));
      Written written{.path = options_.output + "/" + name_of(id), .ids = {id.text}};
      const std::string place = beside + "/" + name_of(id);
      put(document, place, written);
      std::error_code failed;
      fs::rename(place, written.path, failed);
      if (failed)
        throw base::Error(fmt::format("{}: can't write it: {}", written.path, failed.message()));
      all.push_back(std::move(written));
      progress.done(all.size());
    }
    return all;
  }

 private:
  static scene::Scene scene_of(const archive::Source& source) {
    auto scene = archive::scene_of(source);
    if (scene) return std::move(scene).value();
    throw base::Error(base::ExitCode::bad_archive,
                      fmt::format("{}: {}", source.name(), scene.error()));
  }

  /// Letters and digits, whatever an archive says.
  static std::string run_letters(const std::string& run_id) {
    std::string letters;
    for (const char letter : run_id) {
      if (std::isalnum(static_cast<unsigned char>(letter)) != 0 && letters.size() < k_run_letters)
        letters += letter;
    }
    return letters.empty() ? "run" : letters;
  }

  static void make_folder(const std::string& path) {
    std::error_code failed;
    fs::create_directories(path, failed);
    if (!failed && fs::is_directory(path)) return;
    throw base::Error(fmt::format("{}: can't make this folder: {}", path,
                                  failed ? failed.message() : "a file has its name"));
  }

  void put(const gltf::Document& document, const std::string& place, Written& written) {
    const auto glb = gltf::glb_of(document, {.fps = options_.fps});
    if (!glb) {
      throw base::Error(
          fmt::format("{}: animation {} {}", source_.name(), written.ids.front(), glb.error()));
    }
    write_file(place, written.path, [&](std::ostream& file) { file << glb.value().bytes; });
    written.bytes = glb.value().bytes.size();
  }

  const archive::Source& source_;
  const ExportAnimationsOptions& options_;
  scene::Scene scene_;
  gltf::Extras extras_;
};

void tell(const ExportAnimationsOptions& options, const std::vector<Written>& all) {
  std::uint64_t bytes = 0;
  std::size_t animations = 0;
  nlohmann::ordered_json files = nlohmann::ordered_json::array();
  for (const Written& written : all) {
    bytes += written.bytes;
    animations += written.ids.size();
    files.push_back({{"path", written.path}, {"ids", written.ids}, {"bytes", written.bytes}});
  }
  if (options.json) {
    fmt::print("{}\n", dumped({{"archive", options.path},
                               {"format", options.format},
                               {"written", std::move(files)}}));
    return;
  }
  fmt::print("{}: {} animation{}, {} file{}, {:.1f} MB\n", options.output, animations,
             animations == 1 ? "" : "s", all.size(), all.size() == 1 ? "" : "s",
             static_cast<double>(bytes) / 1e6);
}

/// Step two, of one file: `place` is where to write it.
std::vector<Written> write_one_file(const archive::Source& source,
                                    const ExportAnimationsOptions& options,
                                    std::span<const AnimationId> ids, const std::string& place) {
  if (options.format == "glb") {
    if (ids.size() > 1 && !options.together) {
      refuse_usage(fmt::format(
          "{}: one file can't hold {} animations by themselves; add --together for clips of one "
          "file, or give a folder",
          options.output, ids.size()));
    }
    return {GlbExport(source, options).write_one(ids, place)};
  }
  Written written{.path = options.output, .ids = {}};
  for (const AnimationId& id : ids)
    written.ids.push_back(id.text);
  write_file(place, options.output, [&](std::ostream& file) {
    write_animations_csv(source, ids, options.table, file);
    written.bytes = static_cast<std::uint64_t>(std::max<std::streamoff>(0, file.tellp()));
  });
  return {written};
}

/// A folder beside the files, for those that are not whole; it is gone at the end.
class Workshop {
 public:
  explicit Workshop(const std::string& output)
      : path_(fmt::format("{}/.sleight-export.{}", output, ::getpid())) {}
  Workshop(const Workshop&) = delete;
  Workshop& operator=(const Workshop&) = delete;
  ~Workshop() {
    std::error_code none;
    fs::remove_all(path_, none);
  }
  const std::string& path() const { return path_; }

 private:
  std::string path_;
};

}  // namespace

std::vector<std::string> export_formats() {
  return {"glb", "csv", "png", "svg", "mp4"};
}

std::vector<std::string> export_tables() {
  return {"animations", "segments", "points"};
}

int export_animations(const ExportAnimationsOptions& options) {
  check(options);
  if (options.output.empty()) {
    return with_archive(options.path, [&](const archive::Source& source) {
      write_animations_csv(source, choose(source, options), options.table, std::cout);
      return k_ok;
    });
  }
  refuse_same_file(options.path, options.output);
  if (is_file_of(options.output, options.format)) {
    refuse_others_file(options.output, options.force);
    OutputBeside output(options.output);
    // What was written is told when it is in its place: so the file is renamed by the child, which
    // alone knows what it holds.
    return with_archive(options.path, [&](const archive::Source& source) {
      const auto written = write_one_file(source, options, choose(source, options), output.path());
      output.put_in_place();
      tell(options, written);
      return k_ok;
    });
  }
  const Workshop workshop(options.output);
  return with_archive(options.path, [&](const archive::Source& source) {
    const std::vector<AnimationId> ids = choose(source, options);
    tell(options, GlbExport(source, options).write_each(ids, workshop.path()));
    return k_ok;
  });
}

}  // namespace sleight::cli
