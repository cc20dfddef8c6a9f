#include "common/store/stored_motions.h"

#include <fmt/format.h>

#include <array>
#include <filesystem>
#include <span>
#include <system_error>
#include <utility>

#include "common/logging/log.h"
#include "common/motion/fields.h"
#include "common/store/checksum.h"
#include "common/store/database.h"

namespace sleight::store {
namespace {

// The key is the whole state, so that two states never share a motion.
constexpr const char* k_motions_schema = R"(
  CREATE TABLE IF NOT EXISTS motion(
    state BLOB PRIMARY KEY, ends INTEGER NOT NULL, columns INTEGER NOT NULL, numbers BLOB NOT NULL,
    checksum INTEGER NOT NULL);
)";

/// Stored size of a segment. Each element of a field is stored as a double.
constexpr std::size_t k_segment_bytes = motion::k_elements * sizeof(double);

base::Bytes bytes_of(std::span<const motion::Segment> segments) {
  base::ByteWriter writer;
  for (const motion::Segment& segment : segments) {
    motion::for_each_field(motion::k_fields, [&](const auto& field) {
      for (const auto element : motion::elements_of(segment.*field.member))
        writer.put(static_cast<double>(element));
    });
  }
  return writer.take();
}

/// Returns nothing if the bytes are not a whole number of segments.
std::optional<std::vector<motion::Segment>> segments_of(base::BytesView bytes) {
  if (bytes.size() % k_segment_bytes != 0) return std::nullopt;
  std::vector<motion::Segment> segments(bytes.size() / k_segment_bytes);
  base::ByteReader reader(bytes);
  bool is_sound = true;
  for (motion::Segment& segment : segments) {
    motion::for_each_field(motion::k_fields,
                           [&]<class Value>(const motion::Field<motion::Segment, Value>& field) {
                             std::array<double, motion::k_width<Value>> numbers{};
                             for (double& number : numbers)
                               number = reader.get<double>().value();
                             const auto value = motion::value_of<Value>(numbers.data());
                             is_sound = is_sound && value.has_value();
                             segment.*field.member = value.value_or(segment.*field.member);
                           });
  }
  return is_sound ? std::optional(std::move(segments)) : std::nullopt;
}

/// Returns the bytes as a map key. The key is a string, because GCC 12 wrongly warns if vectors of
/// bytes are compared.
std::string text_of(base::BytesView bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

std::uintmax_t bytes_of_file(const std::string& path) {
  std::error_code failure;
  const std::uintmax_t bytes = std::filesystem::file_size(path, failure);
  return failure ? 0 : bytes;
}

}  // namespace

struct StoredMotions::File {
  explicit File(const std::string& path) : database(path, Access::read_write) {
    // Don't sync. If a power failure loses motions, they are simulated again. Don't wait for other
    // processes.
    database.execute("PRAGMA synchronous=OFF");
    database.execute("PRAGMA busy_timeout=200");
    database.execute(k_motions_schema);
    find.emplace(
        database.prepare("SELECT ends, columns, numbers, checksum FROM motion WHERE state=?1"));
    insert.emplace(database.prepare("INSERT OR REPLACE INTO motion VALUES(?1,?2,?3,?4,?5)"));
  }
  Database database;
  std::optional<Statement> find;
  std::optional<Statement> insert;
};

StoredMotions::StoredMotions(const std::string& folder, const std::string& owner,
                             std::uint64_t file_bytes_max)
    : path_(path(folder)), salt_(salt_of(owner)), file_bytes_max_(file_bytes_max) {
  attempt([] {});
}

StoredMotions::~StoredMotions() {
  attempt([this] { write(); });
}

void StoredMotions::attempt(const std::function<void()>& act) {
  for (int tries = 0; is_usable_ && tries < 2; ++tries) {
    try {
      if (!file_) file_ = std::make_unique<File>(path_);
      act();
      return;
    } catch (const DatabaseError& failure) {
      const bool is_made_anew = failure.kind() == DatabaseError::Kind::damaged && tries == 0;
      if (is_made_anew || failure.kind() == DatabaseError::Kind::full) remove_file();
      if (!is_made_anew) give_up(failure.reason());
    }
  }
}

void StoredMotions::remove_file() {
  file_.reset();
  for (const char* suffix : {"", "-wal", "-shm"}) {
    std::error_code ignored;
    std::filesystem::remove(path_ + suffix, ignored);
  }
}

void StoredMotions::give_up(const std::string& reason) {
  is_usable_ = false;
  file_.reset();
  waiting_.clear();
  logging::warn(fmt::format(
      "can't use {}: {}; kept animations will be simulated again for each archive, with the same "
      "result",
      path_, reason));
}

std::optional<archive::Motion> StoredMotions::find(base::BytesView state) {
  if (const auto known = waiting_.find(text_of(state)); known != waiting_.end())
    return known->second;
  std::optional<archive::Motion> found;
  attempt([&] { found = read(state); });
  return found;
}

std::optional<archive::Motion> StoredMotions::read(base::BytesView state) {
  Statement& select = *file_->find;
  select.bind(1, state);
  std::optional<archive::Motion> motion;
  if (select.step()) {
    const std::int64_t ends = select.integer(0);
    const base::BytesView numbers = select.blob(2);
    const bool is_ours =
        select.integer(1) == motion::k_elements &&
        select.integer(3) == checksum_of_motion(salt_, state, ends, motion::k_elements, numbers);
    if (auto segments = segments_of(numbers); is_ours && segments)
      motion = archive::Motion{.ends = static_cast<archive::PlaysOut>(ends),
                               .segments = *std::move(segments)};
  }
  select.reset();
  return motion;
}

void StoredMotions::keep(base::BytesView state, const archive::Motion& motion) {
  if (!is_usable_ || is_full_) return;
  waiting_bytes_ += state.size() + motion.segments.size() * k_segment_bytes;
  waiting_.insert_or_assign(text_of(state), motion);
  if (waiting_bytes_ >= k_motions_bytes) attempt([this] { write(); });
}

void StoredMotions::write() {
  if (waiting_.empty()) return;
  file_->database.execute("BEGIN IMMEDIATE");
  for (const auto& [text, motion] : waiting_) {
    const base::BytesView state = base::bytes_of(std::span<const char>(text));
    const auto ends = static_cast<std::int64_t>(motion.ends);
    const base::Bytes numbers = bytes_of(motion.segments);
    file_->insert->bind(1, state)
        .bind(2, ends)
        .bind(3, static_cast<std::int64_t>(motion::k_elements))
        .bind(4, base::BytesView(numbers))
        .bind(5, checksum_of_motion(salt_, state, ends, motion::k_elements, numbers))
        .run();
  }
  file_->database.execute("COMMIT");
  waiting_.clear();
  waiting_bytes_ = 0;
  is_full_ = bytes_of_file(path_) + bytes_of_file(path_ + "-wal") >= file_bytes_max_;
}

}  // namespace sleight::store
