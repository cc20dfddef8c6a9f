#include "common/random/discrete_distributions.h"

#include <limits>
#include <numeric>

#include "common/base/check.h"
#include "common/math/elementary.h"

namespace sleight::random {

namespace {

// __int128 is a compiler extension. Both supported compilers have it.
__extension__ using Wide = unsigned __int128;

}  // namespace

bool Bernoulli::draw(Stream& stream) const {
  CHECK(p >= 0 && p <= 1);
  return stream.uniform() < p;
}

double Bernoulli::log_density(bool x) const {
  CHECK(p >= 0 && p <= 1);
  return x ? math::log(p) : math::log1p(-p);
}

std::uint64_t UniformInteger::draw(Stream& stream) const {
  CHECK_GT(count, 0U);
  // The draw is the high half of word * count. The low half shows whether the word is in the
  // incomplete last part of the 2^64 words, which would make some draws more likely.
  Wide product = Wide{stream.bits()} * count;
  if (static_cast<std::uint64_t>(product) < count) {
    const std::uint64_t refused_below = (0 - count) % count;  // 2^64 mod count.
    // Fewer than half of all words are refused, so 1000 consecutive refusals don't occur.
    constexpr int k_words_max = 1000;
    int words = 1;
    while (static_cast<std::uint64_t>(product) < refused_below) {
      CHECK_LT(words, k_words_max);
      product = Wide{stream.bits()} * count;
      ++words;
    }
  }
  return static_cast<std::uint64_t>(product >> 64);
}

double UniformInteger::log_density(std::uint64_t x) const {
  CHECK_GT(count, 0U);
  if (x >= count) return -std::numeric_limits<double>::infinity();
  return -math::log(static_cast<double>(count));
}

std::size_t draw_by_share(std::span<const double> shares, Stream& stream) {
  double u = stream.uniform() * std::accumulate(shares.begin(), shares.end(), 0.0);
  // Because of rounding, u may be beyond all shares. Then the last nonzero share is drawn.
  std::size_t drawn = 0;
  for (std::size_t i = 0; i < shares.size(); ++i) {
    if (shares[i] == 0) continue;
    drawn = i;
    if (u < shares[i]) break;
    u -= shares[i];
  }
  return drawn;
}

}  // namespace sleight::random
