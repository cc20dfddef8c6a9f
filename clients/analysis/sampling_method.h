// How an archive was sampled, as its request says: which of its draws are comparable hangs on it.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "common/archive/model.h"
#include "common/request/direction_request.h"

namespace sleight::analysis {

/// None where the text is no request, or names no method that is known here.
std::optional<request::Method> method_of(std::string_view request_text);

/// The method's word as the request has it, known here or not; empty where the text is no request.
std::string method_word(std::string_view request_text);

/// Whether the ladders in /tempering are those of a burn-in, whose scans are no draws.
bool burns_in(std::optional<request::Method> method);

/// Whether an archive has no draws but those after a burn-in by islands or from a search: then all
/// are judged, and how many simulations there were is not in it.
bool draws_are_burnt_in(const archive::Source& source, std::optional<request::Method> method);

/// The scans of a tour where each draw ends one of its own from a fresh start; none where chains go
/// on and on, or the text is no request.
std::optional<std::int64_t> tour_scans_of(std::string_view request_text);

}  // namespace sleight::analysis
