// Texts that occur in the store's errors about damaged files. Supervisors recognise such errors by
// these texts, because supervisors receive only the message of a run's end
// (common/events/run_end.h). No further attempt can succeed with a damaged store.
//
// Pure; thread-safe.
#pragma once

#include <string_view>

namespace sleight::store {

/// This text in a message of refuse_damaged (checksum.h) means: a file was changed.
inline constexpr std::string_view k_damaged_words = ": damaged: ";
/// This text in a message of DatabaseError means: the file is not a database.
inline constexpr std::string_view k_no_store_words = "the file is not a run store or is damaged";

/// Returns whether an error message contains one of these texts.
bool tells_of_damage(std::string_view words);

}  // namespace sleight::store
