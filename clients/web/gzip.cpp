#include "clients/web/gzip.h"

#include <zlib.h>

#include <algorithm>
#include <cstddef>
#include <limits>
#include <new>

namespace sleight::web {

std::string gzipped(std::string_view plain) {
  z_stream stream{};
  // The maximum window; adding 16 selects gzip's format.
  constexpr int k_gzip_window = 15 + 16;
  constexpr int k_memory_level = 8;
  if (deflateInit2(&stream, Z_BEST_COMPRESSION, Z_DEFLATED, k_gzip_window, k_memory_level,
                   Z_DEFAULT_STRATEGY) != Z_OK)
    throw std::bad_alloc();
  std::string packed(deflateBound(&stream, plain.size()), '\0');
  // zlib counts in 32 bits, and its input pointer isn't const.
  constexpr std::size_t k_at_once = std::numeric_limits<uInt>::max() / 2;
  std::size_t taken = 0;
  std::size_t given = 0;
  int outcome = Z_OK;
  while (outcome == Z_OK) {
    const std::size_t in = std::min(k_at_once, plain.size() - taken);
    const std::size_t out = std::min(k_at_once, packed.size() - given);
    stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(plain.data() + taken));
    stream.avail_in = static_cast<uInt>(in);
    stream.next_out = reinterpret_cast<Bytef*>(packed.data() + given);
    stream.avail_out = static_cast<uInt>(out);
    outcome = deflate(&stream, taken + in == plain.size() ? Z_FINISH : Z_NO_FLUSH);
    taken += in - stream.avail_in;
    given += out - stream.avail_out;
  }
  deflateEnd(&stream);
  packed.resize(given);
  return packed;
}

}  // namespace sleight::web
