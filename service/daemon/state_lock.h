// One daemon a state folder: `lock` in it is held as long as the daemon lives.
//
// Thread safety: a resource of one thread.
#pragma once

#include <string>

namespace sleight::daemon {

class StateLock {
 public:
  /// Throws base::Error: conflict, naming the other process, where it is taken.
  explicit StateLock(const std::string& state);
  ~StateLock();
  StateLock(const StateLock&) = delete;
  StateLock& operator=(const StateLock&) = delete;

 private:
  int descriptor_ = -1;
};

}  // namespace sleight::daemon
