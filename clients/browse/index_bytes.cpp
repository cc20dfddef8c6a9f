#include "clients/browse/index_bytes.h"

#include <atomic>
#include <cstring>
#include <future>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "clients/browse/distinct_vectors.h"
#include "clients/browse/parallel.h"
#include "common/hash/sha256.h"

namespace sleight::browse {
namespace {

/// Format number. If a cached index has another version, the index is read again from the archive.
constexpr std::string_view k_beginning = "sleight-browse-index 2\n";
constexpr std::size_t k_piece_bytes = 7 * sizeof(double) + sizeof(std::uint32_t);
constexpr std::uint64_t k_text_max = 1 << 20;

class Writer {
 public:
  template <class T>
  requires std::is_arithmetic_v<T>
  void put(T value) { writer_.put(value); }
  /// Writes the text without its length.
  void put_letters(std::string_view text) {
    for (const char letter : text)
      writer_.put(letter);
  }
  void put(std::string_view text) {
    put(std::uint64_t{text.size()});
    put_letters(text);
  }
  void put(const math::Vec3& v) {
    for (Eigen::Index axis = 0; axis < 3; ++axis)
      put(v[axis]);
  }
  void put(base::BytesView bytes) { writer_.put(bytes); }
  base::Bytes take() { return writer_.take(); }

 private:
  base::ByteWriter writer_;
};

class Reader {
 public:
  explicit Reader(base::BytesView bytes) : reader_(bytes), rest_(bytes.size()) {}

  template <class T>
  T get() {
    const auto value = reader_.get<T>();
    is_good = is_good && value.has_value();
    return value.value_or(T{});
  }
  std::string text() {
    const auto size = get<std::uint64_t>();
    std::string text;
    if (size > k_text_max) is_good = false;
    for (std::uint64_t i = 0; is_good && i < size; ++i)
      text += static_cast<char>(get<std::uint8_t>());
    return text;
  }
  /// Reads a count of items that have at least this many bytes each.
  std::size_t count(std::size_t bytes_each) {
    const auto count = get<std::uint64_t>();
    if (count > rest_ / bytes_each) is_good = false;
    return is_good ? count : 0;
  }
  math::Vec3 vector() {
    const double x = get<double>();
    const double y = get<double>();
    return {x, y, get<double>()};
  }
  /// Reads bytes after their count.
  base::BytesView bytes() {
    const auto found = reader_.bytes(count(1));
    is_good = is_good && found.has_value();
    return found.value_or(base::BytesView());
  }
  bool at_end() const { return reader_.at_end(); }

  bool is_good = true;

 private:
  base::ByteReader reader_;
  std::size_t rest_;
};

void put_entry(const Entry& entry, DistinctVectors& accelerations, Writer& writer) {
  writer.put(std::uint8_t{entry.name.is_find});
  writer.put(entry.name.chain);
  writer.put(entry.name.draw);
  writer.put(entry.row);
  writer.put(entry.lineage);
  writer.put(std::uint8_t{entry.in_proportion});
  writer.put(entry.end_s);
  writer.put(entry.events);
  for (const double number : entry.numbers)
    writer.put(number);
  writer.put(std::uint64_t{entry.tracks.size()});
  for (const Track& track : entry.tracks)
    writer.put(track.count);
  writer.put(std::uint64_t{entry.pieces.size()});
  for (const Piece& piece : entry.pieces) {
    writer.put(piece.start_s);
    writer.put(piece.position_m);
    writer.put(piece.velocity_mps);
    writer.put(accelerations.row_of(piece.acceleration_mps2));
  }
  writer.put(std::uint64_t{entry.contacts.size()});
  for (const Contact& contact : entry.contacts) {
    writer.put(contact.time_s);
    writer.put(contact.body);
    writer.put(contact.partner);
  }
}

struct Shared {
  std::string run;
  std::size_t numbers;  ///< per entry
  std::vector<math::Vec3> accelerations_mps2;
};

/// Returns nothing if the bytes aren't a valid entry.
std::optional<Entry> entry_of(base::BytesView bytes, const Shared& shared) {
  Reader reader(bytes);
  Entry entry;
  entry.name = {.run = shared.run, .is_find = reader.get<std::uint8_t>() != 0};
  entry.name.chain = reader.get<std::uint64_t>();
  entry.name.draw = reader.get<std::uint64_t>();
  entry.row = reader.get<std::uint64_t>();
  entry.lineage = reader.get<std::int64_t>();
  entry.in_proportion = reader.get<std::uint8_t>() != 0;
  entry.end_s = reader.get<double>();
  entry.events = reader.get<std::uint32_t>();
  for (std::size_t i = 0; reader.is_good && i < shared.numbers; ++i)
    entry.numbers.push_back(reader.get<double>());
  std::uint64_t pieces = 0;
  for (std::size_t i = reader.count(sizeof(std::uint32_t)); reader.is_good && i > 0; --i) {
    const auto count = reader.get<std::uint32_t>();
    entry.tracks.push_back({.first = static_cast<std::uint32_t>(pieces), .count = count});
    pieces += count;
  }
  const std::size_t piece_count = reader.count(k_piece_bytes);
  if (piece_count != pieces) reader.is_good = false;
  entry.pieces.reserve(reader.is_good ? piece_count : 0);
  for (std::size_t i = 0; reader.is_good && i < piece_count; ++i) {
    const double start_s = reader.get<double>();
    const math::Vec3 position_m = reader.vector();
    const math::Vec3 velocity_mps = reader.vector();
    const auto row = reader.get<std::uint32_t>();
    if (row >= shared.accelerations_mps2.size()) return std::nullopt;
    entry.pieces.push_back({.start_s = start_s,
                            .position_m = position_m,
                            .velocity_mps = velocity_mps,
                            .acceleration_mps2 = shared.accelerations_mps2[row]});
  }
  for (std::size_t i = reader.count(sizeof(double)); reader.is_good && i > 0; --i) {
    const double time_s = reader.get<double>();
    const auto body = reader.get<std::uint32_t>();
    entry.contacts.push_back(
        {.time_s = time_s, .body = body, .partner = reader.get<std::uint32_t>()});
  }
  if (!reader.is_good || !reader.at_end()) return std::nullopt;
  measure_reach(entry);
  return entry;
}

/// Decodes the bytes between the format number and the checksum.
std::optional<Index> index_of_content(base::BytesView bytes, std::size_t threads) {
  Reader reader(bytes);
  Index index;
  index.run_id = reader.text();
  index.digest = reader.text();
  index.world = reader.text();
  for (std::size_t i = reader.count(2 * sizeof(std::uint64_t)); reader.is_good && i > 0; --i) {
    std::string name = reader.text();
    index.numbers.push_back({.name = std::move(name), .unit = reader.text()});
  }
  std::vector<base::BytesView> entries;
  for (std::size_t i = reader.count(sizeof(std::uint64_t)); reader.is_good && i > 0; --i)
    entries.push_back(reader.bytes());
  Shared shared{.run = index.run_id, .numbers = index.numbers.size(), .accelerations_mps2 = {}};
  for (std::size_t i = reader.count(3 * sizeof(double)); reader.is_good && i > 0; --i)
    shared.accelerations_mps2.push_back(reader.vector());
  if (!reader.is_good || !reader.at_end()) return std::nullopt;
  index.entries.resize(entries.size());
  std::atomic<bool> is_good = true;
  for_each_block(entries.size(), threads, [&](std::size_t first, std::size_t end) {
    for (std::size_t i = first; is_good && i < end; ++i) {
      if (auto entry = entry_of(entries[i], shared))
        index.entries[i] = std::move(*entry);
      else
        is_good = false;
    }
  });
  if (!is_good) return std::nullopt;
  return index;
}

}  // namespace

base::Bytes bytes_of(const Index& index) {
  Writer writer;
  writer.put_letters(k_beginning);
  writer.put(std::string_view(index.run_id));
  writer.put(std::string_view(index.digest));
  writer.put(std::string_view(index.world));
  writer.put(std::uint64_t{index.numbers.size()});
  for (const NumberName& number : index.numbers) {
    writer.put(std::string_view(number.name));
    writer.put(std::string_view(number.unit));
  }
  // Write each entry after its length, so that several entries can be decoded at once.
  DistinctVectors accelerations;
  writer.put(std::uint64_t{index.entries.size()});
  for (const Entry& entry : index.entries) {
    Writer own;
    put_entry(entry, accelerations, own);
    const base::Bytes bytes = own.take();
    writer.put(std::uint64_t{bytes.size()});
    writer.put(bytes);
  }
  writer.put(std::uint64_t{accelerations.numbers().size() / 3});
  for (const double number : accelerations.numbers())
    writer.put(number);
  base::Bytes bytes = writer.take();
  const auto sum = hash::sha256_of(bytes);
  bytes.insert(bytes.end(), sum.begin(), sum.end());
  return bytes;
}

std::optional<Index> index_of(base::BytesView bytes, std::size_t threads) {
  const auto beginning = std::as_bytes(std::span(k_beginning));
  hash::Sha256::Value sum{};
  if (bytes.size() < beginning.size() + sum.size() ||
      std::memcmp(bytes.data(), beginning.data(), beginning.size()) != 0)
    return std::nullopt;
  const base::BytesView content = bytes.first(bytes.size() - sum.size());
  std::memcpy(sum.data(), bytes.data() + content.size(), sum.size());
  // Verify the checksum in parallel with decoding, since both take about equally long.
  std::future<bool> is_right = std::async(threads > 1 ? std::launch::async : std::launch::deferred,
                                          [&] { return sum == hash::sha256_of(content); });
  std::optional<Index> index = index_of_content(content.subspan(beginning.size()), threads);
  return is_right.get() ? std::move(index) : std::nullopt;
}

}  // namespace sleight::browse
