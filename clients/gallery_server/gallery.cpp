#include "clients/gallery_server/gallery.h"

#include <malloc.h>

#include <algorithm>
#include <new>
#include <utility>

#include <fmt/format.h>

#include "clients/gallery_server/summary_json.h"
#include "common/base/error.h"

namespace sleight::gallery {
namespace {

using Json = json::Value;

/// Minimum time between two reports of reading progress.
constexpr auto k_tell_every = std::chrono::milliseconds(250);
/// Number of animations shown while an archive is read for the first time. Above this number, not
/// all pairs of animations are compared.
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

/// Maximum time that a request waits for motions.
constexpr auto k_wait_max = std::chrono::seconds(2);
/// Delay before an outline's motions are read without a request. During the delay, the page can use
/// the processor for loading.
constexpr auto k_outline_alone = std::chrono::seconds(2);

/// Computes the first groups, and stores the outline if worthwhile.
void prepare_groups(const Snapshot& snapshot, const std::string& path, bool has_outline) {
  try {
    snapshot.first_groups();
    if (!has_outline) snapshot.keep_outline(path);
  } catch (const std::exception&) {  // out of memory or threads: the request for groups reports it
  }
}

/// An error's message without the file's name before it.
std::string reason_of(const std::string& what, const std::string& path) {
  const std::string prefix = path + ": ";
  return what.starts_with(prefix) ? what.substr(prefix.size()) : what;
}

}  // namespace

Gallery::Gallery(GalleryOptions options)
    : options_(std::move(options)),
      generation_(
          static_cast<std::uint64_t>(std::chrono::duration_cast<std::chrono::milliseconds>(
                                         std::chrono::system_clock::now().time_since_epoch())
                                         .count())) {
  look_through_folders();
  looking_ = std::thread([this] { look_forever(); });
}

Gallery::~Gallery() {
  {
    const std::lock_guard lock(mutex_);
    is_over_ = true;
    changed_.notify_all();
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
    changed_.wait_for(lock, std::chrono::duration<double>(options_.look_every_s), [this] {
      return is_over_ || std::ranges::any_of(shown_, [](const auto& shown) {
               return shown->may_become_whole() && shown->is_wanted;
             });
    });
    if (is_over_) return;
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
      // If two archives have the same name, the later one is shown with its folder.
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
  Reading reading;
  const std::optional<browse::FileState> file = browse::state_of_file(path_of(archive));
  {
    const std::lock_guard lock(mutex_);
    Shown& shown = *shown_[archive];
    reading.path = shown.path;
    if (!file) {
      const bool was_known = shown.state == ArchiveState::gone;
      shown.state = ArchiveState::gone;
      shown.words = shown.snapshot ? "The archive file no longer exists; loaded data stays visible."
                    : shown.is_live ? "The job has not committed anything yet."
                                    : "The archive file doesn't exist (yet).";
      shown.tried.reset();
      if (was_known) return;
    } else if (shown.tried == file) {
      const auto alone = std::chrono::steady_clock::now() - shown.outlined_at;
      const bool is_due = shown.is_wanted || alone >= k_outline_alone;
      if (!shown.may_become_whole() || !is_due) return;
      reading.outline = shown.snapshot;
    } else {
      shown.tried = file;
      if (!shown.has_outline()) reading.before = shown.snapshot;
      if (!reading.before) {
        shown.state = ArchiveState::reading;
        shown.words.clear();
      }
    }
  }
  if (!file) {
    tell();
    return;
  }
  reading.file = *file;
  // The motions are read at a later check.
  if (!reading.before && !reading.outline && show_outline(archive, reading)) return;
  // Shows the first animations while a long archive is read for the first time.
  std::uint64_t beginning_max = reading.before || reading.outline ? 0 : k_beginning;
  while (true) {
    std::string fault;
    std::shared_ptr<const Snapshot> now;
    try {
      now = read(archive, reading, beginning_max);
    } catch (const base::Error& error) {
      fault = reason_of(error.what(), reading.path);
    } catch (const std::bad_alloc&) {
      fault = "there is not enough memory to read the archive";
    }
    show(archive, now, fault);
    // Release the memory that was used for reading.
    ::malloc_trim(0);
    tell();
    if (!now) return;
    if (!now->is_beginning()) {
      // Pages show the first archive first; its groups are computed while the page loads.
      const bool has_outline = reading.outline != nullptr;
      if (archive == 0) prepare_groups(*now, reading.path, has_outline);
      return;
    }
    beginning_max = 0;
  }
}

bool Gallery::show_outline(std::size_t archive, const Reading& reading) {
  auto kept = browse::kept_outline(reading.path, reading.file);
  if (!kept) return false;
  std::shared_ptr<const Snapshot> outline;
  try {
    outline = std::make_shared<const Snapshot>(reading.path,
                                               Snapshot::Options{.generation = new_generation(),
                                                                 .file = reading.file,
                                                                 .outline = &*kept,
                                                                 .open = options_.open});
  } catch (const std::exception&) {  // the error is reported when the whole archive is read
    return false;
  }
  show(archive, outline, "");
  tell();
  return true;
}

std::shared_ptr<const Snapshot> Gallery::read(std::size_t archive, const Reading& reading,
                                              std::uint64_t beginning_max) {
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
  return std::make_shared<const Snapshot>(
      reading.path, Snapshot::Options{.generation = reading.outline ? reading.outline->generation()
                                                                    : new_generation(),
                                      .file = reading.file,
                                      .earlier = reading.before.get(),
                                      .beginning_max = beginning_max,
                                      .progress = progress,
                                      .open = options_.open});
}

std::uint64_t Gallery::new_generation() {
  const std::lock_guard lock(mutex_);
  return ++generation_;
}

void Gallery::show(std::size_t archive, std::shared_ptr<const Snapshot> now,
                   const std::string& fault) {
  const std::lock_guard lock(mutex_);
  Shown& shown = *shown_[archive];
  shown.read = shown.of = 0;
  changed_.notify_all();
  if (now) {
    shown.is_wanted = false;
    shown.outlined_at = std::chrono::steady_clock::now();
    shown.snapshot = std::move(now);
    shown.state = ArchiveState::ready;
    shown.words.clear();
    return;
  }
  shown.state = ArchiveState::damaged;
  shown.words = shown.snapshot ? fmt::format(
                                     "The archive is no longer readable: {}. Loaded data stays "
                                     "visible.",
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

std::shared_ptr<const Snapshot> Gallery::whole_snapshot(std::size_t archive) const {
  std::unique_lock lock(mutex_);
  if (archive >= shown_.size()) return nullptr;
  Shown& shown = *shown_[archive];
  if (shown.has_outline()) {
    shown.is_wanted = true;
    changed_.notify_all();
    changed_.wait_for(lock, k_wait_max, [&] {
      const bool may_come =
          shown.state == ArchiveState::reading || shown.state == ArchiveState::ready;
      return is_over_ || !shown.has_outline() || !may_come;
    });
  }
  return shown.has_outline() ? nullptr : shown.snapshot;
}

std::string Gallery::why_unreadable(std::size_t archive) const {
  const std::lock_guard lock(mutex_);
  if (archive >= shown_.size()) return {};
  const Shown& shown = *shown_[archive];
  const bool is_unreadable =
      shown.state == ArchiveState::damaged || shown.state == ArchiveState::gone;
  return is_unreadable ? shown.words : std::string();
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
