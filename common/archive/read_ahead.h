// A source that answers a row of small questions out of few large ones: of a reader in another
// process each question costs as much as thousands of values (remote/remote_source.h).
//
// Who reads a dataset from one place on, as the motions of one animation after the other, gets the
// next values out of a block that was asked for at once. Values and errors are those of the source;
// what of a damaged file can be read alone can still be.
//
// Thread safety: as the source's, and one thread at a time.
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

/// Values of a block: 128 kB of the widest.
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
    std::uint64_t next = 0;   ///< where the last question ended
    std::uint64_t begin = 0;  ///< of the block
    std::uint64_t end = 0;    ///< behind it; begin: there is none
    Values block{};
  };

  std::unique_ptr<Source> source_;
  mutable std::map<std::string, Reading, std::less<>> readings_;  ///< by path
};

}  // namespace sleight::archive
