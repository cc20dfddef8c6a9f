#include "common/random/stream.h"

#include <Random123/philox.h>

#include "common/base/check.h"

namespace sleight::random {

Stream::Stream(const StreamKey& key, std::uint64_t iteration)
    : seed_(key.seed),
      lane_(std::uint64_t{key.chain.value} << 32 | key.replica.value),
      iteration_(iteration),
      purpose_(key.purpose) {
  CHECK_NE(static_cast<std::uint32_t>(key.purpose), 0U);
}

void Stream::refill() {
  const r123::Philox4x64_R<10>::ctr_type counter = {
      {block_, iteration_, static_cast<std::uint32_t>(purpose_), 0}};
  const r123::Philox4x64_R<10>::key_type key = {{seed_, lane_}};
  const auto block = r123::Philox4x64_R<10>{}(counter, key);
  for (std::size_t i = 0; i < words_.size(); ++i)
    words_[i] = block[i];
  ++block_;
  next_ = 0;
}

}  // namespace sleight::random
