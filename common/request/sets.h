// Keys that the command line gives in place of a request's file: `--set sampler.seed=7`.
//
// A set is SECTION.KEY=VALUE. VALUE is a TOML value; a word that is none is a string, so that
// `--set world.word=HI` needs no quotes within quotes. It replaces what the file says of that key,
// or adds it, before anything is read: so a set has the errors that the file would have, with
// `--set sampler.sed=1` in the place's stead.
//
// A range makes a group of requests, one for each value: `sampler.seed=1..20` (whole numbers, both
// ends included), or a list `sampler.chains={1,4,16}` of values and ranges. Several ranges make all
// combinations; those of the first set change slowest.
//
// Invariants
//   1. Sets of a combination have distinct keys, so their order changes nothing.
//   2. A group has at most k_combinations_max requests, and there is at least one.
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

/// One key and its value. Made by expand_sets and plain_sets.
struct KeySet {
  std::string text;     ///< "sampler.seed=3", printable
  std::string section;  ///< empty: none was named, which reading refuses
  std::string key;
  Value value;
};

/// Requests of a group.
inline constexpr std::size_t k_combinations_max = 10'000;
/// Sets of one request.
inline constexpr std::size_t k_sets_max = 100;

/// The sets of each request that `texts` ask for, or what is wrong with these; without ranges one
/// combination, without texts an empty one.
base::Result<std::vector<std::vector<KeySet>>, std::vector<Diagnostic>> expand_sets(
    std::span<const std::string> texts);

/// expand_sets for what runs one request: a range is an error that says what takes it.
base::Result<std::vector<KeySet>, std::vector<Diagnostic>> plain_sets(
    std::span<const std::string> texts);

/// Whether one of them sets SECTION.KEY, or any key of the section where `key` is empty. For
/// options that give the same.
const KeySet* find_set(std::span<const KeySet> sets, std::string_view section,
                       std::string_view key = {});

/// Puts each value in its place of the document. Places are {0, n + 1} of the n-th set, as of an
/// error in no file.
void apply_sets(Document& document, std::span<const KeySet> sets);

/// As read_request, of the text with these sets. Errors of a set have its text as file, and
/// k_no_place. `asked` replaces [stop], whatever sets say of it.
base::Result<DirectionRequest, std::vector<Diagnostic>> read_request_with(
    std::string_view text, std::string_view file, std::span<const WorldBinding> worlds,
    std::span<const KeySet> sets, std::optional<Asked> asked = {});

}  // namespace sleight::request
