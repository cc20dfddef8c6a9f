// A source that combines many small reads into few large ones. A question to a reader process costs
// as much as transferring thousands of values (remote/remote_source.h).
//
// If reads of a dataset are sequential, such as reads of one motion after another, this source
// reads a block in advance. Values and errors are the same as without reading ahead. The intact
// parts of a damaged file remain readable.
//
// Thread safety: one thread at a time.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "common/archive/model.h"

namespace sleight::archive {

/// Number of elements in a block. For the largest type, a block has 128 kB.
inline constexpr std::uint64_t k_read_ahead = 16'384;

class ReadAhead final : public Source {
 public:
  explicit ReadAhead(std::unique_ptr<Source> source) : source_(std::move(source)) {}

  std::string name() const override { return source_->name(); }
  const std::vector<Group>& groups() const override { return source_->groups(); }
  Values read(std::string_view group, std::string_view dataset, std::uint64_t first,
              std::uint64_t count) const override;

 private:
  struct Reading {
    std::uint64_t next = 0;   ///< end of the last read
    std::uint64_t begin = 0;  ///< start of the block
    std::uint64_t end = 0;    ///< end of the block; equal to begin: no block
    Values block{};
  };

  std::unique_ptr<Source> source_;
  mutable std::map<std::string, Reading, std::less<>> readings_;  ///< by path
};

}  // namespace sleight::archive
