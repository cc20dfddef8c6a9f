// The parameters of one world, read from a request's text, for callers that know which world it is.
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "common/request/direction_request.h"

namespace sleight::request {

/// A world's parameters as the text has them, or why its first error is one. `binding` is the
/// world's own, as worlds::dice::request_binding.
template <class Parameters>
base::Result<Parameters, std::string> world_parameters(std::string_view text,
                                                       WorldBinding (*binding)(Parameters&)) {
  Parameters parameters;
  const WorldBinding bound = binding(parameters);
  const auto request = read_request(text, "", std::span(&bound, 1));
  if (!request) return request.error().front().message;
  return parameters;
}

}  // namespace sleight::request
