// Files that stand for in-memory archives. A gallery watches the files and reads the archives from
// memory.
#pragma once

#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <utility>

#include "clients/gallery_server/snapshot.h"
#include "common/base/error.h"
#include "tests/archive/memory_archive.h"
#include "tests/unit/clients/gallery_server/made_up.h"

namespace sleight::gallery::testing {

class ShownFiles {
 public:
  /// Replaces the file by renaming, as the archive writer does.
  void put(const std::string& path, archive::MemoryArchive archive) {
    {
      const std::lock_guard lock(mutex_);
      archives_[path] = std::make_shared<const archive::MemoryArchive>(std::move(archive));
    }
    touch(path);
  }
  void damage(const std::string& path) {
    {
      const std::lock_guard lock(mutex_);
      archives_.erase(path);
    }
    touch(path);
  }

  Opener opener() {
    return [this](const std::string& path) -> std::unique_ptr<archive::Source> {
      const std::lock_guard lock(mutex_);
      const auto found = archives_.find(path);
      if (found == archives_.end())
        throw base::Error(base::ExitCode::bad_archive, path + ": it is damaged");
      return std::make_unique<archive::MemoryArchive>(*found->second);
    };
  }

 private:
  void touch(const std::string& path) {
    std::ofstream(path + ".tmp") << ++written_;
    std::filesystem::rename(path + ".tmp", path);
  }

  std::mutex mutex_;
  std::map<std::string, std::shared_ptr<const archive::MemoryArchive>> archives_;
  int written_ = 0;
};

}  // namespace sleight::gallery::testing
