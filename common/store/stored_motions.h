// Motions of kept animations, remembered beside a run's store: `motions.sqlite` in its folder.
//
// It is no part of the run: it may be deleted at any time, and what it has lost or got wrong is
// simulated again. So nothing waits for the disk, every row carries a checksum, and a file that
// can't be used is made anew; where that fails too, nothing is remembered, which is said once.
// Motions belong to one request and one program version: a results version does not cover readers.
//
// Thread safety: one thread at a time; several processes may have one file.
#pragma once

#include <cstddef>
#include <map>
#include <memory>
#include <optional>
#include <string>

#include "common/archive/remembering_reader.h"

namespace sleight::store {

/// Motions are written when so many bytes wait.
inline constexpr std::size_t k_motions_bytes = 8U << 20U;

class StoredMotions final : public archive::Motions {
 public:
  /// Opens or makes the file. `owner`: what the motions hang on besides the state, as text.
  StoredMotions(const std::string& folder, const std::string& owner);
  /// Writes what waits, if it can.
  ~StoredMotions() override;
  StoredMotions(const StoredMotions&) = delete;
  StoredMotions& operator=(const StoredMotions&) = delete;

  std::optional<archive::Motion> find(base::BytesView state) override;
  void keep(base::BytesView state, const archive::Motion& motion) override;

  static std::string path(const std::string& folder) { return folder + "/motions.sqlite"; }

 private:
  struct File;
  void open(const std::string& owner);
  void write();
  void give_up(const std::string& reason);

  std::string path_;
  std::unique_ptr<File> file_;                        ///< null: nothing is remembered
  std::map<std::string, archive::Motion> waiting_{};  ///< by state
  std::size_t waiting_bytes_ = 0;
};

}  // namespace sleight::store
