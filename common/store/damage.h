// How the store's errors report damaged files, and how callers recognise these errors. Only the
// message of a run's end is transmitted (common/events/run_end.h), and no further attempt can
// succeed with such a store.
//
// Pure; thread-safe.
#pragma once

#include <string_view>

namespace sleight::store {

/// In messages of refuse_damaged (checksum.h): a file was changed.
inline constexpr std::string_view k_damaged_words = ": damaged: ";
/// In messages of DatabaseError: the file is not a database.
inline constexpr std::string_view k_no_store_words = "the file is not a run store or is damaged";

/// Returns whether an error message contains one of these texts.
bool tells_of_damage(std::string_view words);

}  // namespace sleight::store
