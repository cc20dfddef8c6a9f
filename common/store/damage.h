// Texts by which callers recognise the store's errors about damaged files. A supervisor needs them
// because it receives only the message of a run's end (common/events/run_end.h). No further attempt
// can succeed with a damaged store.
//
// Pure; thread-safe.
#pragma once

#include <string_view>

namespace sleight::store {

/// Text in messages of refuse_damaged (checksum.h): a file was changed.
inline constexpr std::string_view k_damaged_words = ": damaged: ";
/// Text in messages of DatabaseError: the file is not a database.
inline constexpr std::string_view k_no_store_words = "the file is not a run store or is damaged";

/// Returns whether an error message contains one of these texts.
bool tells_of_damage(std::string_view words);

}  // namespace sleight::store
