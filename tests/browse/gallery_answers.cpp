// Writes the C++ programs' answers to random questions about an archive's animations.
// tests/programs/test_gallery_search.py compares these answers with those of a saved page.
//
// Usage: `sleight-gallery-answers ARCHIVE.h5 FOLDER QUERIES SETS SEED`.
//
// The program writes three files into the folder. index.bin is the file that a saved page searches.
// questions.jsonl and answers.jsonl have one JSON object per line. The program also damages each
// random query's text: it removes, inserts or exchanges characters. Most damaged texts are invalid.
// For a damaged text, the page must report the same error at the same place. The program groups
// sets of animations, and searches each set for animations that resemble some of its members.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <limits>
#include <numeric>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "clients/browse/groups.h"
#include "clients/browse/query.h"
#include "clients/browse/reading.h"
#include "clients/gallery_server/index_columns.h"
#include "common/archive/hdf5/reader.h"
#include "common/base/error.h"
#include "common/json/value.h"
#include "tests/browse/slow_query.h"

namespace {

using namespace sleight;
using Json = json::Value;
using Entries = std::vector<std::size_t>;

constexpr int k_depth = 3;
/// Words, signs and numbers of queries. The program inserts them at wrong places of texts.
constexpr auto k_put_in = std::to_array<std::string_view>({" and ",
                                                           " or ",
                                                           " then ",
                                                           " not ",
                                                           "(",
                                                           ")",
                                                           "..",
                                                           "mm",
                                                           "s",
                                                           " deg",
                                                           "1e-400",
                                                           "1e999",
                                                           "1e-310",
                                                           ".5",
                                                           "5.",
                                                           "\"",
                                                           "\\",
                                                           " any ",
                                                           "every ",
                                                           " touches ",
                                                           " ends in ",
                                                           " in ",
                                                           "x 0..1",
                                                           " during 0..1s",
                                                           ":",
                                                           ",",
                                                           "<",
                                                           ">=",
                                                           "[1]",
                                                           "[",
                                                           "\xc3\xa9",
                                                           "\xe2\x82\xac",
                                                           "\x01",
                                                           "log_prio",
                                                           "chian",
                                                           "table",
                                                           " 3 ",
                                                           "mm/s",
                                                           "m/",
                                                           "_",
                                                           "-",
                                                           "A",
                                                           "Log-Prior < 3"});

std::size_t below(random::Stream& stream, std::size_t bound) {
  return std::min(bound - 1,
                  static_cast<std::size_t>(stream.uniform() * static_cast<double>(bound)));
}

bool goes_on(char c) {
  return (static_cast<unsigned char>(c) & 0xC0U) == 0x80U;
}

/// Returns `at`, or the end of the multi-byte character that contains `at`.
std::size_t between_characters(const std::string& text, std::size_t at) {
  while (at < text.size() && goes_on(text[at]))
    ++at;
  return std::min(at, text.size());
}

std::string torn(std::string text, random::Stream& stream) {
  constexpr std::size_t k_cut_max = 8;
  for (std::size_t edits = 1 + below(stream, 2); edits > 0; --edits) {
    const std::size_t begin = between_characters(text, below(stream, text.size() + 1));
    const std::size_t end = between_characters(text, begin + below(stream, k_cut_max));
    if (stream.uniform() < 0.5) text.erase(begin, end - begin);
    if (stream.uniform() < 0.7) text.insert(begin, k_put_in.at(below(stream, k_put_in.size())));
  }
  return text;
}

class Answers {
 public:
  Answers(const browse::Index& index, const std::string& folder)
      : index_(index),
        questions_(folder + "/questions.jsonl"),
        answers_(folder + "/answers.jsonl") {
    for (const browse::Entry& entry : index.entries)
      all_.push_back(&entry);
    set_.emplace(all_, index.scene, 1);
  }

  void find(const std::string& text) {
    Json answer;
    const auto condition = browse::parse_query(text, index_.scene, index_.numbers);
    if (condition) {
      answer["entries"] = browse::find(condition.value(), index_);
    } else {
      const auto before = std::string_view(text).substr(0, condition.error().column);
      answer["column"] = 1 + std::ranges::count_if(before, [](char c) { return !goes_on(c); });
      answer["message"] = condition.error().message;
    }
    say({{"find", text}}, answer);
  }

  void groups(const Entries& of, std::size_t count, browse::Grouping by) {
    std::vector<const browse::Entry*> entries;
    for (const std::size_t entry : of)
      entries.push_back(all_[entry]);
    const auto found = browse::groups_of(entries, index_.scene, {.groups = count, .by = by});
    Json groups = Json::array();
    for (const browse::AlikeGroup& group : found.groups) {
      Entries members;
      for (const std::size_t member : group.members)
        members.push_back(of[member]);
      groups.push_back({{"representative", of[group.representative]},
                        {"members", members},
                        {"mean_m", group.mean_m},
                        {"greatest_m", group.greatest_m}});
    }
    const char* way = by == browse::Grouping::medoids ? "medoids" : "hierarchy";
    say({{"groups", {{"entries", of}, {"groups", count}, {"by", way}}}},
        {{"approximate", found.is_approximate}, {"groups", groups}});
  }

  void alike(const Entries& to, const Entries& of) {
    std::vector<std::pair<double, std::size_t>> nearest;
    for (const std::size_t entry : of) {
      double least = std::numeric_limits<double>::infinity();
      for (const std::size_t one : to)
        least = std::min(least, set_->between(one, entry).value_m());
      nearest.emplace_back(least, entry);
    }
    std::ranges::sort(nearest);
    Json answer{{"entries", Json::array()}, {"distance_m", Json::array()}};
    for (const auto& [distance_m, entry] : nearest) {
      answer["entries"].push_back(entry);
      answer["distance_m"].push_back(distance_m);
    }
    say({{"alike", {{"to", to}, {"entries", of}}}}, answer);
  }

 private:
  void say(const Json& question, const Json& answer) {
    questions_ << question.dump() << '\n';
    answers_ << answer.dump() << '\n';
  }

  const browse::Index& index_;
  std::vector<const browse::Entry*> all_{};
  std::optional<browse::AlikeSet> set_{};  ///< as the server compares
  std::ofstream questions_;
  std::ofstream answers_;
};

/// Returns a random subset with at least one animation, sometimes in reverse order.
Entries some_of(const browse::Index& index, random::Stream& stream) {
  const double part = stream.uniform();
  Entries some{below(stream, index.entries.size())};
  for (std::size_t entry = 0; entry < index.entries.size(); ++entry) {
    if (entry != some.front() && stream.uniform() < part) some.push_back(entry);
  }
  if (stream.uniform() < 0.5) std::ranges::reverse(some);
  return some;
}

int answer(const std::string& archive, const std::string& folder, std::uint64_t queries,
           std::uint64_t sets, std::uint64_t seed) {
  constexpr std::size_t k_groups_max =
      200;  // large sets with more than 100 groups have another sample
  const auto source = archive::hdf5::open_file(archive);
  auto read = browse::read_index(*source);
  if (!read || read.value().index.entries.empty()) {
    fmt::print(stderr, "{}: {}\n", archive, read ? "no animations" : read.error());
    return 6;
  }
  const browse::Index index = std::move(read).value().index;
  std::ofstream(folder + "/index.bin", std::ios::binary) << gallery::index_columns(index, 1);
  Answers answers(index, folder);
  for (std::uint64_t n = 0; n < queries; ++n) {
    random::Stream stream({.seed = seed, .purpose = random::Purpose::prior}, n);
    const auto condition = browse::testing::random_condition(index, stream, k_depth);
    const auto text = browse::testing::text_of(condition, index);
    if (!text) continue;
    answers.find(*text);
    answers.find("any " + torn(*text, stream));
    answers.find(torn(*text, stream) + ")");
  }
  for (std::uint64_t n = 0; n < sets; ++n) {
    random::Stream stream({.seed = seed, .purpose = random::Purpose::resampling}, n);
    const auto count = 1 + static_cast<std::size_t>(k_groups_max * std::pow(stream.uniform(), 3));
    answers.groups(some_of(index, stream), count,
                   n % 2 == 0 ? browse::Grouping::medoids : browse::Grouping::hierarchy);
    Entries to = some_of(index, stream);
    to.resize(std::min<std::size_t>(to.size(), 1 + n % 3));
    answers.alike(to, some_of(index, stream));
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 6) {
    fmt::print(stderr, "usage: sleight-gallery-answers ARCHIVE.h5 FOLDER QUERIES SETS SEED\n");
    return 2;
  }
  const auto number = [&](int i) { return std::strtoull(argv[i], nullptr, 10); };
  try {
    return answer(argv[1], argv[2], number(3), number(4), number(5));
  } catch (const base::Error& error) {
    fmt::print(stderr, "{}\n", error.what());
    return static_cast<int>(error.exit_code());
  }
}
