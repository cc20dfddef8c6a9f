// Keys given on the command line instead of in a request's file: `--set sampler.seed=7`.
//
// A set is SECTION.KEY=VALUE. VALUE is a TOML value. A word that is no TOML value counts as a
// string, so `--set world.word=HI` needs no nested quotes. Tables within a section, and their keys,
// can't be set. Each `--set` replaces or adds its key before the request is read. So a `--set` is
// checked like a file, and errors have a place such as `--set sampler.sed=1`.
//
// A range makes a group of requests, one per value. A range is `sampler.seed=1..20` (integers, both
// ends included), or a list such as `sampler.chains={1,4,16}`. A list's items are values and
// ranges. Several ranges yield all combinations. The first range's value changes slowest.
//
// Invariants
//   1. Sets of a combination have distinct keys, so their order doesn't matter.
//   2. A group has 1 to k_combinations_max requests.
// Values and pure functions; thread-safe.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/result.h"
#include "common/request/direction_request.h"
#include "common/request/document.h"

namespace sleight::request {

/// A key and its value, made by expand_sets or plain_sets.
struct KeySet {
  std::string text;     ///< "sampler.seed=3", printable
  std::string section;  ///< empty: no section given, which is an error on reading
  std::string key;      ///< "seed"
  Value value;
};

/// Maximum requests of a group.
inline constexpr std::size_t k_combinations_max = 10'000;
/// Maximum sets of a request.
inline constexpr std::size_t k_sets_max = 100;

/// Returns the sets of each request described by `texts`, or the errors. Without ranges there is
/// one combination. Without texts, the only combination is empty.
base::Result<std::vector<std::vector<KeySet>>, std::vector<Diagnostic>> expand_sets(
    std::span<const std::string> texts);

/// Like expand_sets, but for a single request. A range is an error. The error names the commands
/// that accept ranges.
base::Result<std::vector<KeySet>, std::vector<Diagnostic>> plain_sets(
    std::span<const std::string> texts);

/// Returns the set of SECTION.KEY. If `key` is empty, returns a set of any key in the section.
/// Null: there is no such set. Callers use this to detect conflicts with options that set the same
/// key.
const KeySet* find_set(std::span<const KeySet> sets, std::string_view section,
                       std::string_view key = {});

/// Inserts each value into the document. The place of the n-th set is {0, n + 1}. Line 0 marks an
/// error outside the file.
void apply_sets(Document& document, std::span<const KeySet> sets);

/// Like read_request, but first applies these sets to the text. An error in a set has the set's
/// text as its file name, and k_no_place as its place. `asked` replaces [stop] even if sets change
/// [stop].
base::Result<DirectionRequest, std::vector<Diagnostic>> read_request_with(
    std::string_view text, std::string_view file, std::span<const WorldBinding> worlds,
    std::span<const KeySet> sets, std::optional<Asked> asked = {});

}  // namespace sleight::request
