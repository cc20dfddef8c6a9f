// Compresses bytes with gzip (RFC 1952), for browsers.
#pragma once

#include <string>
#include <string_view>

namespace sleight::web {

/// Equal input yields equal output. Throws std::bad_alloc.
std::string gzipped(std::string_view plain);

}  // namespace sleight::web
