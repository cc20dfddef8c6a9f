#include "clients/gallery_server/gallery.h"

#include <malloc.h>

#include <algorithm>
#include <chrono>
#include <new>
#include <nlohmann/json.hpp>
#include <utility>

#include <fmt/format.h>

#include "clients/gallery_server/summary_json.h"
#include "common/base/error.h"

namespace sleight::gallery {
namespace {

using Json = nlohmann::ordered_json;

/// Progress of reading is told so often.
constexpr auto k_tell_every = std::chrono::milliseconds(250);
/// Animations that are shown while the rest of an archive is read for the first time: as many as
/// can be compared with one another.
constexpr std::uint64_t k_beginning = browse::k_full_matrix_max;

const char* word_of(ArchiveState state) {
  switch (state) {
    case ArchiveState::reading:
      return "reading";
    case ArchiveState::ready:
      return "ready";
    case ArchiveState::gone:
      return "gone";
    case ArchiveState::damaged:
      return "damaged";
  }
  return "";
}

void prepare_groups(const Snapshot& snapshot) {
  try {
    snapshot.prepare_groups();
  } catch (const std::exception&) {  // no memory, no thread: who asks for them is told
  }
}

/// What an error says of a file, without the file's name before it.
std::string reason_of(const std::string& what, const std::string& path) {
  const std::string prefix = path + ": ";
  return what.starts_with(prefix) ? what.substr(prefix.size()) : what;
}

}  // namespace

Gallery::Gallery(GalleryOptions options) : options_(std::move(options)) {
  look_through_folders();
  looking_ = std::thread([this] { look_forever(); });
}

Gallery::~Gallery() {
  {
    const std::lock_guard lock(mutex_);
    is_over_ = true;
    over_.notify_all();
  }
  looking_.join();
}

void Gallery::tell() {
  if (options_.changed) options_.changed();
}

void Gallery::look_forever() {
  while (true) {
    look_through_folders();
    const std::size_t count = archives();
    for (std::size_t archive = 0; archive < count; ++archive)
      look_at(archive);
    std::unique_lock lock(mutex_);
    if (over_.wait_for(lock, std::chrono::duration<double>(options_.look_every_s),
                       [this] { return is_over_; }))
      return;
  }
}

void Gallery::look_through_folders() {
  ListedFiles listed = listed_files(options_.paths);
  bool is_news = false;
  {
    const std::lock_guard lock(mutex_);
    for (const auto& [path, name] : listed.files) {
      if (std::ranges::any_of(shown_, [&](const auto& shown) { return shown->path == path; }))
        continue;
      // Of two that are called the same the later one has its folder too.
      const bool is_taken =
          std::ranges::any_of(shown_, [&](const auto& shown) { return shown->name == name; });
      auto shown = std::make_unique<Shown>();
      shown->name = is_taken ? path : name;
      shown->path = path;
      shown_.push_back(std::move(shown));
      is_news = true;
    }
    is_news = is_news || listed.left_out != left_out_;
    left_out_ = std::move(listed.left_out);
  }
  if (is_news) tell();
}

void Gallery::look_at(std::size_t archive) {
  std::string path;
  std::shared_ptr<const Snapshot> before;
  const std::optional<cli::FileState> file = cli::state_of_file(path_of(archive));
  {
    const std::lock_guard lock(mutex_);
    Shown& shown = *shown_[archive];
    path = shown.path;
    before = shown.snapshot;
    if (!file) {
      const bool was_known = shown.state == ArchiveState::gone;
      shown.state = ArchiveState::gone;
      shown.words = before          ? "The archive's file is gone; this is what was read of it."
                    : shown.is_live ? "The job has committed nothing yet."
                                    : "There is no such file (yet).";
      shown.tried.reset();
      if (was_known) return;
    } else if (shown.tried == file) {
      return;
    } else {
      shown.tried = file;
      if (!before) shown.state = ArchiveState::reading;
    }
  }
  if (!file) {
    tell();
    return;
  }
  // So that there is something to see while many are read for the first time.
  std::uint64_t beginning_max = before ? 0 : k_beginning;
  while (true) {
    std::string fault;
    std::shared_ptr<const Snapshot> now;
    try {
      now = read(archive, path, before.get(), beginning_max);
    } catch (const base::Error& error) {
      fault = reason_of(error.what(), path);
    } catch (const std::bad_alloc&) {
      fault = "reading it takes more memory than there is";
    }
    show(archive, now, fault);
    // What was held while it was read is the system's again.
    ::malloc_trim(0);
    tell();
    if (!now) return;
    if (!now->is_beginning()) {
      // The first archive is what a page shows first; while it is being loaded there is time.
      if (archive == 0) prepare_groups(*now);
      return;
    }
    beginning_max = 0;
  }
}

std::shared_ptr<const Snapshot> Gallery::read(std::size_t archive, const std::string& path,
                                              const Snapshot* before, std::uint64_t beginning_max) {
  std::uint64_t generation = 0;
  {
    const std::lock_guard lock(mutex_);
    generation = ++generation_;
  }
  auto told = std::chrono::steady_clock::now();
  const auto progress = [&](std::uint64_t read, std::uint64_t of) {
    {
      const std::lock_guard lock(mutex_);
      shown_[archive]->read = read;
      shown_[archive]->of = of;
    }
    const auto moment = std::chrono::steady_clock::now();
    if (moment - told < k_tell_every) return;
    told = moment;
    tell();
  };
  return std::make_shared<const Snapshot>(path, Snapshot::Options{.generation = generation,
                                                                  .earlier = before,
                                                                  .beginning_max = beginning_max,
                                                                  .progress = progress,
                                                                  .open = options_.open});
}

void Gallery::show(std::size_t archive, std::shared_ptr<const Snapshot> now,
                   const std::string& fault) {
  const std::lock_guard lock(mutex_);
  Shown& shown = *shown_[archive];
  shown.read = shown.of = 0;
  if (now) {
    shown.snapshot = std::move(now);
    shown.state = ArchiveState::ready;
    shown.words.clear();
    return;
  }
  shown.state = ArchiveState::damaged;
  shown.words = shown.snapshot ? fmt::format(
                                     "The archive can't be read any more: {}. This is what was "
                                     "read before.",
                                     fault)
                               : fault;
}

Json Gallery::state() const {
  const std::lock_guard lock(mutex_);
  Json archives = Json::array();
  for (std::size_t i = 0; i < shown_.size(); ++i) {
    const Shown& shown = *shown_[i];
    Json json{
        {"id", i},
        {"name", shown.name},
        {"state", word_of(shown.state)},
        {"words", shown.words},
        {"reading", shown.of == 0 ? Json(nullptr) : Json{{"done", shown.read}, {"of", shown.of}}},
        {"is_live", shown.is_live},
        {"live_words", shown.live_words}};
    if (shown.snapshot) {
      add_facts(json, *shown.snapshot);
    } else {
      add_no_facts(json);
    }
    archives.push_back(std::move(json));
  }
  Json left_out = Json::array();
  for (const ListedFiles::LeftOut& left : left_out_)
    left_out.push_back({{"name", left.name}, {"reason", left.reason}});
  return {{"archives", std::move(archives)}, {"left_out", std::move(left_out)}};
}

std::shared_ptr<const Snapshot> Gallery::snapshot(std::size_t archive) const {
  const std::lock_guard lock(mutex_);
  return archive < shown_.size() ? shown_[archive]->snapshot : nullptr;
}

std::size_t Gallery::archives() const {
  const std::lock_guard lock(mutex_);
  return shown_.size();
}

std::string Gallery::path_of(std::size_t archive) const {
  const std::lock_guard lock(mutex_);
  return archive < shown_.size() ? shown_[archive]->path : std::string();
}

void Gallery::set_live(const std::string& path, bool is_live, const std::string& words) {
  {
    const std::lock_guard lock(mutex_);
    for (const auto& shown : shown_) {
      if (shown->path != path) continue;
      shown->is_live = is_live;
      shown->live_words = words;
    }
  }
  tell();
}

}  // namespace sleight::gallery
