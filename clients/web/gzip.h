// Bytes compressed as gzip (RFC 1952), which browsers take apart.
#pragma once

#include <string>
#include <string_view>

namespace sleight::web {

/// The same bytes, the same result. Throws std::bad_alloc.
std::string gzipped(std::string_view plain);

}  // namespace sleight::web
