#include "common/store/stored_motions.h"

#include <fmt/format.h>

#include <cstdint>
#include <cstring>
#include <filesystem>
#include <span>
#include <system_error>
#include <vector>

#include "common/base/error.h"
#include "common/logging/log.h"
#include "common/store/checksum.h"
#include "common/store/database.h"

namespace sleight::store {
namespace {

// The key is the whole state: two states never share a motion.
constexpr const char* k_schema = R"(
  CREATE TABLE IF NOT EXISTS owner(text TEXT NOT NULL);
  CREATE TABLE IF NOT EXISTS motion(
    state BLOB PRIMARY KEY, ends INTEGER NOT NULL, columns INTEGER NOT NULL, numbers BLOB NOT NULL,
    checksum INTEGER NOT NULL);
)";

std::int64_t sum_of(base::BytesView state, const archive::Motion& motion) {
  return checksum_of_motion(state, static_cast<std::int64_t>(motion.ends), motion.recording.columns,
                            base::bytes_of(std::span<const double>(motion.recording.values)));
}

/// As a map's key: GCC 12 warns wrongly where vectors of bytes are compared.
std::string text_of(base::BytesView bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

}  // namespace

struct StoredMotions::File {
  explicit File(const std::string& path) : database(path, Access::read_write) {
    // What a loss of power takes is simulated again, and others are not waited for.
    database.execute("PRAGMA synchronous=OFF");
    database.execute("PRAGMA busy_timeout=200");
    database.execute(k_schema);
    find.emplace(
        database.prepare("SELECT ends, columns, numbers, checksum FROM motion WHERE state=?1"));
    insert.emplace(database.prepare("INSERT OR IGNORE INTO motion VALUES(?1,?2,?3,?4,?5)"));
  }
  Database database;
  std::optional<Statement> find;
  std::optional<Statement> insert;
};

StoredMotions::StoredMotions(const std::string& folder, const std::string& owner)
    : path_(path(folder)) {
  try {
    open(owner);
  } catch (const base::Error&) {
    // Damaged, or something else: made anew.
    file_.reset();
    for (const char* suffix : {"", "-wal", "-shm"}) {
      std::error_code ignored;
      std::filesystem::remove(path_ + suffix, ignored);
    }
    try {
      open(owner);
    } catch (const base::Error& failure) {
      give_up(failure.what());
    }
  }
}

StoredMotions::~StoredMotions() {
  write();
}

void StoredMotions::open(const std::string& owner) {
  file_ = std::make_unique<File>(path_);
  Database& database = file_->database;
  Statement known = database.prepare("SELECT text FROM owner");
  const bool is_known = known.step();
  if (is_known && known.text(0) == owner) return;
  known.reset();
  database.execute("BEGIN IMMEDIATE");
  database.execute("DELETE FROM motion");
  database.execute("DELETE FROM owner");
  database.prepare("INSERT INTO owner VALUES(?1)").bind(1, owner).run();
  database.execute("COMMIT");
}

void StoredMotions::give_up(const std::string& reason) {
  file_.reset();
  waiting_.clear();
  logging::warn(
      fmt::format("motions of kept animations are not remembered, and each archive simulates them "
                  "anew: {}",
                  reason));
}

std::optional<archive::Motion> StoredMotions::find(base::BytesView state) {
  if (!file_) return std::nullopt;
  if (const auto known = waiting_.find(text_of(state)); known != waiting_.end()) {
    return known->second;
  }
  try {
    Statement& select = *file_->find;
    select.reset();
    select.bind(1, state);
    if (!select.step()) return std::nullopt;
    const base::BytesView numbers = select.blob(2);
    archive::Motion motion{
        .ends = static_cast<archive::PlaysOut>(select.integer(0)),
        .recording = {.columns = static_cast<std::size_t>(select.integer(1)), .values = {}}};
    motion.recording.values.resize(numbers.size() / sizeof(double));
    std::memcpy(motion.recording.values.data(), numbers.data(),
                motion.recording.values.size() * sizeof(double));
    const bool is_sound =
        sum_of(state, motion) == select.integer(3) && numbers.size() % sizeof(double) == 0;
    select.reset();
    if (is_sound) return motion;
    file_->database.prepare("DELETE FROM motion WHERE state=?1").bind(1, state).run();
  } catch (const base::Error& failure) {
    give_up(failure.what());
  }
  return std::nullopt;
}

void StoredMotions::keep(base::BytesView state, const archive::Motion& motion) {
  if (!file_) return;
  waiting_bytes_ += state.size() + motion.recording.values.size() * sizeof(double);
  waiting_.insert_or_assign(text_of(state), motion);
  if (waiting_bytes_ >= k_motions_bytes) write();
}

void StoredMotions::write() {
  if (!file_ || waiting_.empty()) return;
  try {
    file_->database.execute("BEGIN IMMEDIATE");
    for (const auto& [state, motion] : waiting_) {
      file_->insert->bind(1, base::bytes_of(std::span<const char>(state)))
          .bind(2, static_cast<std::int64_t>(motion.ends))
          .bind(3, static_cast<std::int64_t>(motion.recording.columns))
          .bind(4, base::bytes_of(std::span<const double>(motion.recording.values)))
          .bind(5, sum_of(base::bytes_of(std::span<const char>(state)), motion))
          .run();
    }
    file_->database.execute("COMMIT");
    waiting_.clear();
    waiting_bytes_ = 0;
  } catch (const base::Error& failure) {
    give_up(failure.what());
  }
}

}  // namespace sleight::store
