// A file that is received in pieces. The pieces are written to a temporary file, the part. When the
// part is complete, its digest is checked and the part is renamed. So the file is complete or
// absent.
//
// The part's name includes the start of the digest: `.ball.h5.0123456789abcdef.part`. So a later
// attempt resumes a part only if the content is the same.
//
// Thread safety: a PartFile belongs to one thread. If two processes fetch the same file, the second
// is refused.
#pragma once

#include <cstdint>
#include <string>

#include "common/base/bytes.h"
#include "common/hash/sha256.h"
#include "common/rpc/client.h"

namespace sleight::rpc {

class PartFile {
 public:
  /// Opens the part and hashes the bytes already there. Follows symbolic links in `path`. All
  /// functions throw base::Error.
  PartFile(const std::string& path, FileView view);
  /// Leaves the part for the next attempt, unless it is empty.
  ~PartFile();
  PartFile(const PartFile&) = delete;
  PartFile& operator=(const PartFile&) = delete;

  std::uint64_t bytes() const { return bytes_; }
  bool is_whole() const { return bytes_ == view_.size; }

  /// REQUIRES: `piece` is not longer than the missing rest.
  void append(base::BytesView piece);

  /// Moves the part to its place durably, and removes parts of other contents. Before the move,
  /// calls `check` with the part's path. If the content does not match the announced digest,
  /// removes the part and returns false. The part is also removed if `check` throws, or if another
  /// file at its place must be kept. REQUIRES: is_whole(), first call.
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
