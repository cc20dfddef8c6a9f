#include "clients/browse/index_bytes.h"

#include <array>
#include <cstring>
#include <string>
#include <type_traits>
#include <utility>

#include "common/hash/sha256.h"

namespace sleight::browse {
namespace {

/// Another number for another form: an index of another version is made anew.
constexpr std::string_view k_beginning = "sleight-browse-index 1\n";
constexpr std::size_t k_piece_doubles = 10;
constexpr std::uint64_t k_text_max = 1 << 20;

class Writer {
 public:
  template <class T>
  requires std::is_arithmetic_v<T>
  void put(T value) { writer_.put(value); }
  /// Without its length.
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
  void put(const Piece& piece) {
    put(piece.start_s);
    put(piece.position_m);
    put(piece.velocity_mps);
    put(piece.acceleration_mps2);
  }
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
  /// How many follow, each of at least so many bytes.
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
  bool at_end() const { return reader_.at_end(); }

  bool is_good = true;

 private:
  base::ByteReader reader_;
  std::size_t rest_;
};

void put_entry(const Entry& entry, Writer& writer) {
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
  for (const Piece& piece : entry.pieces)
    writer.put(piece);
  writer.put(std::uint64_t{entry.contacts.size()});
  for (const Contact& contact : entry.contacts) {
    writer.put(contact.time_s);
    writer.put(contact.body);
    writer.put(contact.partner);
  }
}

Entry get_entry(Reader& reader, const std::string& run, std::size_t numbers) {
  Entry entry;
  entry.name = {.run = run, .is_find = reader.get<std::uint8_t>() != 0};
  entry.name.chain = reader.get<std::uint64_t>();
  entry.name.draw = reader.get<std::uint64_t>();
  entry.row = reader.get<std::uint64_t>();
  entry.lineage = reader.get<std::int64_t>();
  entry.in_proportion = reader.get<std::uint8_t>() != 0;
  entry.end_s = reader.get<double>();
  entry.events = reader.get<std::uint32_t>();
  for (std::size_t i = 0; reader.is_good && i < numbers; ++i)
    entry.numbers.push_back(reader.get<double>());
  std::uint64_t pieces = 0;
  for (std::size_t i = reader.count(sizeof(std::uint32_t)); reader.is_good && i > 0; --i) {
    const auto count = reader.get<std::uint32_t>();
    entry.tracks.push_back({.first = static_cast<std::uint32_t>(pieces), .count = count});
    pieces += count;
  }
  const std::size_t piece_count = reader.count(k_piece_doubles * sizeof(double));
  if (piece_count != pieces) reader.is_good = false;
  entry.pieces.reserve(reader.is_good ? piece_count : 0);
  for (std::size_t i = 0; reader.is_good && i < piece_count; ++i) {
    const double start_s = reader.get<double>();
    const math::Vec3 position_m = reader.vector();
    const math::Vec3 velocity_mps = reader.vector();
    entry.pieces.push_back({.start_s = start_s,
                            .position_m = position_m,
                            .velocity_mps = velocity_mps,
                            .acceleration_mps2 = reader.vector()});
  }
  for (std::size_t i = reader.count(sizeof(double)); reader.is_good && i > 0; --i) {
    const double time_s = reader.get<double>();
    const auto body = reader.get<std::uint32_t>();
    entry.contacts.push_back(
        {.time_s = time_s, .body = body, .partner = reader.get<std::uint32_t>()});
  }
  if (reader.is_good) measure_reach(entry);
  return entry;
}

hash::Sha256::Value sum_of(base::BytesView bytes) {
  hash::Sha256 sum;
  sum.update(bytes);
  return sum.finish();
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
  writer.put(std::uint64_t{index.entries.size()});
  for (const Entry& entry : index.entries)
    put_entry(entry, writer);
  base::Bytes bytes = writer.take();
  const auto sum = sum_of(bytes);
  bytes.insert(bytes.end(), sum.begin(), sum.end());
  return bytes;
}

std::optional<Index> index_of(base::BytesView bytes) {
  const auto beginning = std::as_bytes(std::span(k_beginning));
  hash::Sha256::Value sum{};
  if (bytes.size() < beginning.size() + sum.size() ||
      std::memcmp(bytes.data(), beginning.data(), beginning.size()) != 0)
    return std::nullopt;
  const base::BytesView content = bytes.first(bytes.size() - sum.size());
  std::memcpy(sum.data(), bytes.data() + content.size(), sum.size());
  if (sum != sum_of(content)) return std::nullopt;
  Reader reader(content.subspan(beginning.size()));
  Index index;
  index.run_id = reader.text();
  index.digest = reader.text();
  index.world = reader.text();
  for (std::size_t i = reader.count(2 * sizeof(std::uint64_t)); reader.is_good && i > 0; --i) {
    std::string name = reader.text();
    index.numbers.push_back({.name = std::move(name), .unit = reader.text()});
  }
  for (std::size_t i = reader.count(sizeof(double)); reader.is_good && i > 0; --i)
    index.entries.push_back(get_entry(reader, index.run_id, index.numbers.size()));
  if (!reader.is_good || !reader.at_end()) return std::nullopt;
  return index;
}

}  // namespace sleight::browse
