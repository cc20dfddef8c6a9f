// How the store's errors say that its files are damaged, and how others tell such errors: of a
// run's end only the words travel (common/events/run_end.h), and no attempt gets further with such
// a store.
//
// Pure; thread-safe.
#pragma once

#include <string_view>

namespace sleight::store {

/// Within the words of refuse_damaged (checksum.h): a file that was changed.
inline constexpr std::string_view k_damaged_words = ": damaged: ";
/// Within those of a DatabaseError whose file is no database any more.
inline constexpr std::string_view k_no_store_words = "the file is not a run store or is damaged";

/// Whether an error's words are one of those.
bool tells_of_damage(std::string_view words);

}  // namespace sleight::store
