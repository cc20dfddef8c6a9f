#include "clients/cli/export_command.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cstddef>
#include <filesystem>
#include <functional>
#include <iostream>
#include <span>
#include <string_view>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "clients/browse/archives/animation_ids.h"
#include "clients/browse/archives/browsed.h"
#include "clients/browse/archives/index_cache.h"
#include "clients/browse/archives/kept_animations.h"
#include "clients/browse/groups.h"
#include "clients/cli/exported_animations.h"
#include "clients/cli/exported_files.h"
#include "clients/cli/groups_command.h"
#include "clients/export/document.h"
#include "clients/pictures/animation_frames.h"
#include "clients/terminal/interruption.h"
#include "clients/terminal/output.h"
#include "common/archive/kept_motions.h"
#include "common/archive/model.h"
#include "common/archive/remote/remote_source.h"
#include "common/archive/summary.h"
#include "common/base/error.h"
#include "common/base/output_beside.h"
#include "common/json/value.h"
#include "common/scene/scene.h"

namespace sleight::cli {
namespace {

[[noreturn]] void refuse(const archive::Source& source, const std::string& reason) {
  throw base::Error(base::ExitCode::usage, fmt::format("{}: {}", source.name(), reason));
}

std::vector<browse::AnimationId> selected(const archive::Source& source,
                                          const ExportChoice& choice) {
  browse::Browsed browsed;
  browsed.archives.push_back(
      {.path = source.name(), .index = index_of(source, source.name(), choice.file)});
  const std::vector<browse::Picked> meant = picked(browsed, {.select = choice.select});
  const auto id_of = [](const browse::Entry& entry) {
    return browse::AnimationId{
        .is_find = entry.name.is_find, .row = entry.row, .text = browse::short_text(entry.name)};
  };
  std::vector<browse::AnimationId> ids;
  if (choice.representatives && !meant.empty()) {
    const browse::Groups groups =
        groups_of(meant, *choice.representatives, browse::Grouping::medoids);
    for (const browse::AlikeGroup& group : groups.groups)
      ids.push_back(id_of(*meant[group.representative].entry));
  } else {
    for (const browse::Picked& one : meant)
      ids.push_back(id_of(*one.entry));
  }
  return ids;
}

namespace fs = std::filesystem;

pictures::FrameViews views_called(const std::string& name) {
  if (name == "above") return pictures::FrameViews::above;
  return name == "front" ? pictures::FrameViews::front : pictures::FrameViews::both;
}

std::uint64_t bytes_at(const std::string& place) {
  std::error_code unknown;
  if (!fs::is_directory(place, unknown)) return fs::file_size(place, unknown);
  std::uint64_t bytes = 0;
  for (fs::directory_iterator it(place, unknown), end; !unknown && it != end; it.increment(unknown))
    bytes += it->file_size();
  return bytes;
}

/// Writes one animation as a picture or film (animation_frames.h) to `place`, completely or not at
/// all. `progress`: finished frames, total frames.
WrittenFile write_film(const archive::Source& source, const scene::Scene& scene,
                       const browse::AnimationId& id, const std::string& place,
                       const ExportAnimationsOptions& options,
                       const std::function<void(std::size_t, std::size_t)>& progress) {
  gltf::Clip clip = clip_of(source, scene, id);
  const std::string title = fmt::format("{} {}", archive::summary_of(source).world, id.text);
  const pictures::ShownAnimation shown{.title = title,
                                       .motion = std::move(clip.motion),
                                       .own = std::move(clip.own),
                                       .offsets_m = std::move(clip.offsets_m)};
  const pictures::FramesOptions frames{.fps = options.fps.value_or(k_film_fps),
                                       .look = {.views = views_called(options.view)},
                                       .scale = options.scale,
                                       .progress = progress};
  if (options.format == "svg") {
    write_motion_svg(title, scene, shown, place);
  } else if (options.format == "png") {
    write_png_frames(scene, shown, place, frames);
  } else {
    write_mp4(scene, shown, place, frames);
  }
  return {.path = place, .ids = {id.text}, .bytes = bytes_at(place)};
}

bool is_file_of(const std::string& output, const std::string& format) {
  return output.ends_with("." + format);
}

bool is_film(const std::string& format) {
  return format == "png" || format == "svg" || format == "mp4";
}

/// Also refuses NaN.
void check_range(const char* option, double value, double low, double high) {
  if (value >= low && value <= high) return;
  terminal::refuse_usage(
      fmt::format("{} {}: expected a number from {} to {}", option, value, low, high));
}

/// Returns "mp4" for "a/b.MP4"; "" without an extension.
std::string ending_of(const std::string& output) {
  std::string ending = fs::path(output).extension().string();
  std::ranges::transform(ending, ending.begin(), [](char c) {
    return static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  });
  return ending.empty() ? ending : ending.substr(1);
}

std::string format_of(const std::string& output) {
  const std::vector<std::string> formats = export_formats();
  const auto found = std::ranges::find(formats, ending_of(output));
  return found == formats.end() ? "glb" : *found;
}

/// Refuses an output name with another format's extension, which is probably a mistake.
void refuse_other_ending(const ExportAnimationsOptions& options) {
  constexpr std::array<std::string_view, 13> k_files{
      "glb", "gltf", "csv", "png", "svg", "mp4", "mov", "avi", "gif", "jpg", "h5", "mkv", "blend"};
  const std::string ending = ending_of(options.output);
  const bool is_right = is_file_of(options.output, options.format) && options.format != "png";
  if (is_right || std::ranges::find(k_files, ending) == k_files.end()) return;
  if (options.format == "png")
    terminal::refuse_usage(
        fmt::format("{}: --format png writes a folder, whose name must not end in .{}",
                    options.output, ending));
  terminal::refuse_usage(
      fmt::format("{}: --format {} requires a file name that ends in .{}, or a folder name that "
                  "does not end in .{}",
                  options.output, options.format, options.format, ending));
}

void check(const ExportAnimationsOptions& options) {
  const std::string& format = options.format;
  const ExportChoice& choice = options.choice;
  if (!choice.ids.empty() && (!choice.select.empty() || choice.representatives))
    terminal::refuse_usage("--ids can't be combined with --select or --representatives");
  for (const std::string& id : choice.ids) {
    if (id.empty() || id.starts_with('-'))
      terminal::refuse_usage(fmt::format("--ids: expected the id of an animation, found '{}'", id));
  }
  if (choice.all && !choice.ids.empty())
    terminal::refuse_usage("--all and --ids can't be combined");
  if (format != "csv" && options.table != "animations")
    terminal::refuse_usage("--table requires --format csv");
  if (format != "csv" && options.output.empty()) {
    terminal::refuse_usage(
        format == "png"
            ? std::string(
                  "-o is required: name a folder; each animation's frames go into a subfolder")
            : fmt::format("-o is required: name a file OUT.{}, or a folder for one file per "
                          "animation",
                          format));
  }
  if (format != "glb" && options.together)
    terminal::refuse_usage("--together requires --format glb");
  if (options.output == "-")
    terminal::refuse_usage(
        "-o -: only --format csv writes to standard output; name a file or folder");
  if (options.together && !is_file_of(options.output, format))
    terminal::refuse_usage(
        fmt::format("{}: --together writes one file, whose name must end in .glb", options.output));
  if (format == "csv" && !options.output.empty() && !is_file_of(options.output, format))
    terminal::refuse_usage(
        fmt::format("{}: expected a file name that ends in .csv", options.output));
  if ((format == "csv" || format == "svg") && options.fps)
    terminal::refuse_usage("--fps requires --format glb, png or mp4");
  if (format != "png" && format != "mp4" && (options.view != "both" || options.scale != 1))
    terminal::refuse_usage("--view and --scale require --format png or mp4");
  if (options.json && options.output.empty())
    terminal::refuse_usage("--json lists the written files, so it requires -o");
  refuse_other_ending(options);
  if (options.fps) check_range("--fps", *options.fps, k_export_fps_min, k_export_fps_max);
  check_range("--scale", options.scale, 1 / k_film_scale_max, k_film_scale_max);
}

/// Chooses animations. Only tables may have any number of animations. Other formats write a file
/// per animation.
std::vector<browse::AnimationId> choose(const archive::Source& source,
                                        const ExportAnimationsOptions& options) {
  return chosen(source, options.choice, options.format != "csv");
}

class GlbExport {
 public:
  GlbExport(const archive::Source& source, const ExportAnimationsOptions& options)
      : source_(source),
        options_(options),
        scene_(browse::required_scene(source)),
        extras_(extras_of(source)) {}

  WrittenFile write_one(std::span<const browse::AnimationId> ids) {
    ExportProgress progress(ids.size());
    gltf::Document document{.scene = scene_, .extras = extras_};
    WrittenFile written{.path = options_.output, .ids = {}};
    for (const browse::AnimationId& id : ids) {
      document.clips.push_back(clip_of(source_, scene_, id));
      written.ids.push_back(id.text);
      progress.done(written.ids.size());
    }
    put(document, written);
    return written;
  }

  std::vector<WrittenFile> write_each(std::span<const browse::AnimationId> ids) {
    ExportProgress progress(ids.size());
    const std::string run_id = archive::summary_of(source_).run_id;
    const auto name_of = [&](const browse::AnimationId& id) {
      return export_name(run_id, id.text) + ".glb";
    };
    for (const browse::AnimationId& id : ids)
      refuse_others_file(options_.output + "/" + name_of(id), options_.force);
    std::vector<WrittenFile> all;
    for (const browse::AnimationId& id : ids) {
      gltf::Document document{.scene = scene_, .extras = extras_};
      document.clips.push_back(clip_of(source_, scene_, id));
      WrittenFile written{.path = options_.output + "/" + name_of(id), .ids = {id.text}};
      put(document, written);
      all.push_back(std::move(written));
      progress.done(all.size());
    }
    return all;
  }

 private:
  void put(const gltf::Document& document, WrittenFile& written) {
    const auto glb = gltf::glb_of(document, {.fps = options_.fps});
    if (!glb) {
      throw base::Error(
          fmt::format("{}: animation {} {}", source_.name(), written.ids.front(), glb.error()));
    }
    base::write_output(written.path, [&](std::ostream& file) { file << glb.value().bytes; });
    written.bytes = glb.value().bytes.size();
  }

  const archive::Source& source_;
  const ExportAnimationsOptions& options_;
  scene::Scene scene_;
  gltf::Extras extras_;
};

void tell(const ExportAnimationsOptions& options, const std::vector<WrittenFile>& all) {
  std::uint64_t bytes = 0;
  std::size_t animations = 0;
  json::Value files = json::Value::array();
  for (const WrittenFile& written : all) {
    bytes += written.bytes;
    animations += written.ids.size();
    files.push_back({{"path", written.path}, {"ids", written.ids}, {"bytes", written.bytes}});
  }
  if (options.json) {
    fmt::print("{}\n", json::Value{{"archive", options.path},
                                   {"format", options.format},
                                   {"written", std::move(files)}}
                           .dump(2));
    return;
  }
  fmt::print("{}: {} animation{}, {} file{}, {:.1f} MB\n", options.output, animations,
             animations == 1 ? "" : "s", all.size(), all.size() == 1 ? "" : "s",
             static_cast<double>(bytes) / 1e6);
}

void require_one(std::span<const browse::AnimationId> ids, const ExportAnimationsOptions& options) {
  if (ids.size() == 1 || options.together) return;
  terminal::refuse_usage(fmt::format(
      "{}: one file can't contain {} separate animations; {}name a folder", options.output,
      ids.size(),
      options.format == "glb" ? "add --together to write all animations to this file, or " : ""));
}

/// Writes all animations to a single file.
std::vector<WrittenFile> write_one_file(const archive::Source& source,
                                        const ExportAnimationsOptions& options,
                                        std::span<const browse::AnimationId> ids) {
  if (options.format == "glb") {
    require_one(ids, options);
    return {GlbExport(source, options).write_one(ids)};
  }
  WrittenFile written{.path = options.output, .ids = {}};
  for (const browse::AnimationId& id : ids)
    written.ids.push_back(id.text);
  base::write_output(options.output, [&](std::ostream& file) {
    write_animations_csv(source, ids, options.table, file);
    written.bytes = static_cast<std::uint64_t>(std::max<std::streamoff>(0, file.tellp()));
    terminal::Interruption::check();
  });
  return {written};
}

/// A table may go to a pipe or a device.
bool is_pipe_for(const ExportAnimationsOptions& options) {
  std::error_code none;
  const fs::file_status status = fs::status(options.output, none);
  return options.format == "csv" && fs::exists(status) && !fs::is_regular_file(status);
}

/// Check all places first, because the drawing that follows may take an hour.
void refuse_taken_place(const std::string& place, const ExportAnimationsOptions& options) {
  std::error_code none;
  if (options.format == "png" && fs::exists(place, none) && !fs::is_empty(place, none)) {
    throw base::Error(base::ExitCode::conflict,
                      fmt::format("{}: already exists, but frames require a new or empty folder; "
                                  "remove it, or name another folder",
                                  place));
  }
  refuse_others_file(place, options.force);
}

/// Writes pictures and films. A complete file is renamed to its place.
std::vector<WrittenFile> write_films(const archive::Source& source,
                                     const ExportAnimationsOptions& options) {
  const std::vector<browse::AnimationId> ids = choose(source, options);
  const bool is_one = options.format != "png" && is_file_of(options.output, options.format);
  if (is_one) require_one(ids, options);
  if (!is_one) make_export_folder(options.output);
  const std::string run_id = archive::summary_of(source).run_id;
  const std::string ending = options.format == "png" ? "" : "." + options.format;
  const auto place_of = [&](const browse::AnimationId& id) {
    return is_one ? options.output
                  : fmt::format("{}/{}{}", options.output, export_name(run_id, id.text), ending);
  };
  for (const browse::AnimationId& id : ids)
    refuse_taken_place(place_of(id), options);
  const scene::Scene scene = browse::required_scene(source);
  ExportProgress progress(ids.size());
  std::vector<WrittenFile> all;
  for (const browse::AnimationId& id : ids) {
    all.push_back(
        write_film(source, scene, id, place_of(id), options,
                   [&](std::size_t done, std::size_t of) { progress.done(all.size(), done, of); }));
    progress.done(all.size());
  }
  return all;
}

}  // namespace

std::vector<browse::AnimationId> chosen(const archive::Source& source, const ExportChoice& choice,
                                        bool is_bounded) {
  if (!choice.ids.empty()) return browse::animations_of(source, choice.ids);
  const bool is_selected = !choice.select.empty() || choice.representatives;
  std::vector<browse::AnimationId> ids =
      is_selected ? selected(source, choice) : browse::animation_ids(source);
  if (ids.empty() && !choice.select.empty()) refuse(source, "no animation matches --select");
  if (ids.empty()) refuse(source, "the archive has no animations; run more scans");
  if (is_bounded && ids.size() > k_export_max && !choice.all && !choice.representatives) {
    refuse(source,
           fmt::format("{} {} animations, above the limit of {}; choose some with --ids, --select "
                       "or --representatives, or add --all",
                       is_selected ? "--select matches" : "the archive has", ids.size(),
                       k_export_max));
  }
  return ids;
}

std::vector<std::string> export_formats() {
  return {"glb", "csv", "png", "svg", "mp4"};
}

std::vector<std::string> export_tables() {
  return {"animations", "segments", "points"};
}

std::vector<std::string> export_views() {
  return {"both", "above", "front"};
}

int export_animations(const ExportAnimationsOptions& given) {
  ExportAnimationsOptions options = given;
  if (options.format.empty()) options.format = format_of(options.output);
  if (options.format == "csv" && options.output == "-") options.output.clear();
  check(options);
  if (!options.output.empty()) terminal::refuse_same_file(options.path, options.output);
  return terminal::with_results([&] {
    const terminal::Interruption interruption;
    options.choice.file = browse::state_of_file(options.path);
    const auto source = archive::remote::open_remote(options.path);
    if (options.output.empty()) {
      write_animations_csv(*source, choose(*source, options), options.table, std::cout);
    } else if (is_film(options.format)) {
      tell(options, write_films(*source, options));
    } else if (is_file_of(options.output, options.format)) {
      if (!is_pipe_for(options)) refuse_others_file(options.output, options.force);
      tell(options, write_one_file(*source, options, choose(*source, options)));
    } else {
      const std::vector<browse::AnimationId> ids = choose(*source, options);
      make_export_folder(options.output);
      tell(options, GlbExport(*source, options).write_each(ids));
    }
    return terminal::k_ok;
  });
}

}  // namespace sleight::cli
