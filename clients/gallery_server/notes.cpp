#include "clients/gallery_server/notes.h"

#include <sys/stat.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <filesystem>
#include <system_error>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "clients/browse/index.h"
#include "clients/terminal/output.h"
#include "common/base/error.h"
#include "common/base/file_system.h"
#include "common/base/output_beside.h"
#include "common/base/own_folder.h"

namespace sleight::gallery {
namespace {

namespace fs = std::filesystem;
using Json = json::Value;

constexpr const char* k_shared_folder = "sleight-notes";
constexpr std::size_t k_file_bytes_max = 64U << 20U;

std::string checked_text(const Json& json, const char* key, std::size_t bytes_max) {
  if (!json.is_string()) terminal::refuse_usage(fmt::format("{} is not a string", key));
  const auto& text = json.text();
  if (text.size() > bytes_max)
    terminal::refuse_usage(fmt::format("{} has more than {} bytes", key, bytes_max));
  return text;
}

bool flag_of(const Json& note, const char* key) {
  const auto* found = note.find(key);
  if (!found) return false;
  if (!found->is_boolean())
    terminal::refuse_usage(fmt::format("{} is neither true nor false", key));
  return found->get<bool>();
}

/// Checks a note and returns its stored form.
Json checked(const Json& note) {
  if (!note.is_object()) terminal::refuse_usage("the note is not an object");
  Json kept{{"star", flag_of(note, "star")},
            {"hidden", flag_of(note, "hidden")},
            {"tags", Json::array()},
            {"note", ""},
            {"changed", 0}};
  if (const auto* tags = note.find("tags"); tags) {
    if (!tags->is_array() || tags->size() > k_tags_max)
      terminal::refuse_usage(
          fmt::format("tags are not a list, or the list has more than {} tags", k_tags_max));
    for (const Json& tag : tags->elements())
      kept["tags"].push_back(checked_text(tag, "a tag", k_tag_bytes_max));
  }
  if (const auto* text = note.find("note"); text)
    kept["note"] = checked_text(*text, "the note", k_note_bytes_max);
  if (const auto* changed = note.find("changed"); changed && changed->is_whole())
    kept["changed"] = *changed;
  return kept;
}

std::vector<std::string> tags_in(const Json& patch, const char* key) {
  const auto* found = patch.find(key);
  if (!found) return {};
  if (!found->is_array()) terminal::refuse_usage(fmt::format("{} is not a list", key));
  std::vector<std::string> tags;
  for (const Json& tag : found->elements())
    tags.push_back(checked_text(tag, "a tag", k_tag_bytes_max));
  return tags;
}

Json patched(const Json& note, const Json& patch) {
  if (!patch.is_object()) terminal::refuse_usage("the change is not an object");
  Json whole = note;
  for (const char* key : {"star", "hidden", "note"})
    if (patch.contains(key)) whole[key] = patch[key];
  const std::vector<std::string> off = tags_in(patch, "tags_off");
  Json tags = Json::array();
  for (const Json& tag : note["tags"].elements())
    if (std::ranges::find(off, tag.get<std::string>()) == off.end()) tags.push_back(tag);
  for (const std::string& tag : tags_in(patch, "tags_on"))
    if (std::ranges::find(tags.elements(), Json(tag)) == tags.elements().end()) tags.push_back(tag);
  whole["tags"] = std::move(tags);
  return checked(whole);
}

bool says_nothing(const Json& note) {
  return !note["star"].get<bool>() && !note["hidden"].get<bool>() && note["tags"].empty() &&
         note["note"].text().empty();
}

/// Creates missing folders, readable only by their owner.
void make_folders(const std::string& folder) {
  fs::path made;
  for (const fs::path& part : fs::path(folder)) {
    made /= part;
    if (::mkdir(made.c_str(), S_IRWXU) != 0 && errno != EEXIST) {
      throw base::Error(fmt::format("{}: {}", made.string(),
                                    std::error_code(errno, std::generic_category()).message()));
    }
  }
}

/// Returns the present form of a name; older galleries wrote "0.250". Returns none if the text
/// isn't a name.
std::optional<std::string> name_today(const std::string& name) {
  const auto asked = browse::parse_name(name);
  if (!asked) return std::nullopt;
  return asked->is_bare ? "c" + name : name;
}

/// Reads a file's notes. The file is untrusted, because others may write to a shared folder. Throws
/// std::exception if the file is invalid.
Json notes_in(const std::string& path) {
  Json notes = Json::object();
  const Json read = Json::parse(base::read_text_file(path, k_file_bytes_max));
  for (const auto& [name, note] : read.at("notes").items()) {
    const auto today = name_today(name);
    if (today && notes.size() < k_notes_max) notes[*today] = checked(note);
  }
  return notes;
}

}  // namespace

bool is_run_word(const std::string& run) {
  return !run.empty() && run.size() <= 128 &&
         std::ranges::all_of(run, [](unsigned char c) { return std::isalnum(c) != 0; });
}

std::string notes_folder(const std::string& archive) {
  std::error_code failure;
  const fs::path shared = fs::path(base::directory_of(archive)) / k_shared_folder;
  if (fs::is_directory(shared, failure)) return shared.string();
  const auto own = base::own_folder("XDG_DATA_HOME", ".local/share", "notes");
  return own ? own->string() : std::string();
}

Notes::Notes(std::string folder) : folder_(std::move(folder)) {
  if (folder_.empty())
    trouble_ = "Stars and notes last only until the gallery ends, because there is no home folder.";
}

Notes::Run& Notes::loaded(const std::string& run) {
  Run& known = runs_[run];
  if (folder_of(known).empty() || !is_run_word(run)) return known;
  const std::string file = file_of(run, known);
  const std::optional<browse::FileState> now = browse::state_of_file(file);
  if (!now || now == known.read) return known;
  known.read = now;
  try {
    known.notes = notes_in(file);
    known.is_unreadable = false;
  } catch (const std::exception&) {
    known.is_unreadable = true;
    trouble_ = fmt::format(
        "The notes in {} are unreadable; new notes of this run last only until the gallery ends.",
        file);
  }
  return known;
}

void Notes::write(const std::string& run, Run& to) {
  if (folder_of(to).empty() || to.is_unreadable) return;
  try {
    make_folders(folder_of(to));
    base::OutputBeside output(file_of(run, to));
    const Json file{{"sleight_notes", 1}, {"run", run}, {"notes", to.notes}};
    base::PosixFileSystem files;
    base::write_text_file(files, output.path(), file.dump(1) + "\n");
    files.sync_file(output.path());
    output.put_in_place();
    to.read = browse::state_of_file(file_of(run, to));
    const bool is_any_unreadable =
        std::ranges::any_of(runs_, [](const auto& one) { return one.second.is_unreadable; });
    if (!is_any_unreadable) trouble_.clear();
  } catch (const base::Error& error) {
    trouble_ = fmt::format("Stars and notes last only until the gallery ends: {}.", error.what());
  }
}

Json Notes::of_run(const std::string& run) {
  const std::lock_guard lock(mutex_);
  return loaded(run).notes;
}

void Notes::keep_in(const std::string& run, const std::string& folder) {
  const std::lock_guard lock(mutex_);
  Run& known = runs_[run];
  if (!known.folder) known.folder = folder;
}

Json Notes::change(const std::string& run, const Json& patches) {
  if (!is_run_word(run)) terminal::refuse_usage("no such run");
  if (!patches.is_object()) terminal::refuse_usage("the changes are not an object");
  const std::lock_guard lock(mutex_);
  Run& of = loaded(run);
  std::uint64_t changed = 0;
  for (const auto& [animation, note] : of.notes.items())
    changed = std::max(changed, note["changed"].get<std::uint64_t>());
  Json now = Json::object();
  std::size_t more = 0;
  for (const auto& [animation, patch] : patches.items()) {
    const auto name = name_today(animation);
    if (!name) terminal::refuse_usage("no such animation");
    Json& kept = now[*name];
    kept = patched(of.notes.value(*name, checked(Json::object())), patch);
    kept["changed"] = changed + 1;
    if (!says_nothing(kept) && !of.notes.contains(*name)) ++more;
  }
  if (more > 0 && of.notes.size() + more > k_notes_max)
    terminal::refuse_usage(fmt::format("a run can have at most {} notes", k_notes_max));
  for (const auto& [animation, kept] : now.items()) {
    if (says_nothing(kept)) {
      of.notes.erase(animation);
    } else {
      of.notes[animation] = kept;
    }
  }
  write(run, of);
  return now;
}

std::string Notes::trouble() const {
  const std::lock_guard lock(mutex_);
  return trouble_;
}

}  // namespace sleight::gallery
