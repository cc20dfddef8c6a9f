// Finds an archive's sampling method in its request.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "common/archive/model.h"
#include "common/request/direction_request.h"

namespace sleight::analysis {

/// Returns nothing if the text isn't a request, or names an unknown method.
std::optional<request::Method> method_of(std::string_view request_text);

/// Returns the request's word for the method, even if the method is unknown. Returns "" if the text
/// isn't a request.
std::string method_word(std::string_view request_text);

/// Whether the ladders in /tempering belong to a burn-in, so that their scans aren't draws.
bool burns_in(std::optional<request::Method> method);

/// Whether all draws come from a search or follow a burn-in by islands. If so, all draws are
/// judged, and the number of simulations is unknown.
bool draws_are_burnt_in(const archive::Source& source, std::optional<request::Method> method);

/// Returns the scans per tour if each draw ends a separate tour. Returns nothing if chains never
/// restart, or if the text isn't a request.
std::optional<std::int64_t> tour_scans_of(std::string_view request_text);

}  // namespace sleight::analysis
