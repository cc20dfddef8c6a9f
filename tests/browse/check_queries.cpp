// Compares fast and slow answers to random queries on an archive's animations.
//
// Usage: `sleight-check-queries ARCHIVE.h5 QUERIES SEED`.
//
// Each query runs on one animation; the animations take turns. If a query has a text, the program
// parses the text, and the parsed query must give the same answer. Answers that depend on the last
// bits of a root are counted, not compared. At the first difference, the program prints a command
// that repeats the query, and exits with 1.
#include <fmt/format.h>

#include <cstdint>
#include <cstdlib>
#include <string>

#include "clients/browse/query.h"
#include "clients/browse/reading.h"
#include "common/archive/hdf5/reader.h"
#include "common/base/error.h"
#include "tests/browse/slow_query.h"

namespace {

using namespace sleight;

constexpr int k_depth = 3;

int check(const std::string& path, std::uint64_t queries, std::uint64_t seed) {
  const auto source = archive::hdf5::open_file(path);
  auto read = browse::read_index(*source);
  if (!read) {
    fmt::print(stderr, "{}: {}\n", path, read.error());
    return 6;
  }
  const browse::Index index = std::move(read).value().index;
  if (index.entries.empty()) {
    fmt::print(stderr, "{}: no animations\n", path);
    return 5;
  }
  std::uint64_t met = 0;
  std::uint64_t close = 0;
  std::uint64_t typed = 0;
  for (std::uint64_t n = 0; n < queries; ++n) {
    random::Stream stream({.seed = seed, .purpose = random::Purpose::prior}, n);
    const browse::Condition condition = browse::testing::random_condition(index, stream, k_depth);
    const browse::Entry& entry = index.entries[n % index.entries.size()];
    const bool fast = browse::is_met(condition, entry);
    if (fast != browse::testing::slow_is_met(condition, entry)) {
      if (browse::testing::is_close_call(condition, entry)) {
        ++close;
      } else {
        fmt::print(stderr, "query {} of seed {}: animation {} is {} by the fast answer alone\n", n,
                   seed, short_text(entry.name), fast ? "meant" : "not meant");
        return 1;
      }
    }
    met += fast ? 1 : 0;
    const auto text = browse::testing::text_of(condition, index);
    if (!text) continue;
    ++typed;
    const auto parsed = browse::parse_query(*text, index.scene, index.numbers);
    if (!parsed || browse::is_met(parsed.value(), entry) != fast) {
      fmt::print(stderr, "query {} of seed {}: animation {}: its text means something else: {}\n",
                 n, seed, short_text(entry.name),
                 parsed ? *text : with_mark(parsed.error(), *text));
      return 1;
    }
  }
  fmt::print(
      "{}: {} queries of {} animations, seed {}: all equal; {} met, {} within rounding, {} typed\n",
      path, queries, index.entries.size(), seed, met, close, typed);
  return close * 1000 <= queries ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 4) {
    fmt::print(stderr, "usage: sleight-check-queries ARCHIVE.h5 QUERIES SEED\n");
    return 2;
  }
  try {
    return check(argv[1], std::strtoull(argv[2], nullptr, 10), std::strtoull(argv[3], nullptr, 10));
  } catch (const base::Error& error) {
    fmt::print(stderr, "{}\n", error.what());
    return static_cast<int>(error.exit_code());
  }
}
