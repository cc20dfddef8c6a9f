// A file that comes in pieces: written beside its place, checked against its digest and renamed, so
// that it is whole or not there.
//
// The part's name has the beginning of the digest in it, `.ball.h5.0123456789abcdef.part`: what an
// attempt left behind is gone on with by the next one of the same content, and by no other.
//
// Thread safety: belongs to one thread; of two processes that fetch one file the second is refused.
#pragma once

#include <cstdint>
#include <string>

#include "common/base/bytes.h"
#include "common/hash/sha256.h"
#include "common/rpc/client.h"

namespace sleight::rpc {

class PartFile {
 public:
  /// Opens the part, and reads what is there of it. Links of `path` are followed. Throws
  /// base::Error, as do the others.
  PartFile(const std::string& path, FileView view);
  /// Leaves the part for the next attempt, if anything came.
  ~PartFile();
  PartFile(const PartFile&) = delete;
  PartFile& operator=(const PartFile&) = delete;

  /// Bytes that are there.
  std::uint64_t bytes() const { return bytes_; }
  bool is_whole() const { return bytes_ == view_.size; }

  /// REQUIRES: not more than is missing.
  void append(base::BytesView piece);

  /// Makes it durable in its place, and removes parts of other contents. False, and the part is
  /// gone, where the content is another than was announced; gone too where `check`, called with
  /// the part's path, throws, or where another file lies at its place and is kept.
  /// REQUIRES: is_whole, not called before.
  [[nodiscard]] bool finish(const FetchCheck& check = {}, AtItsPlace other = AtItsPlace::replaced);

 private:
  void put_in_place(AtItsPlace other);
  void remove_other_parts() const;

  std::string path_;
  std::string part_;
  FileView view_;
  int descriptor_ = -1;
  std::uint64_t bytes_ = 0;
  hash::Sha256 hash_;
};

}  // namespace sleight::rpc
