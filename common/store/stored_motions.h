// A cache of kept animations' motions beside a run's store: `motions.sqlite` in its folder.
//
// The cache is not part of the run. The cache may be deleted at any time. Missing or damaged
// motions are simulated again. So nothing waits for the disk. Every row has a checksum, and a
// damaged file is replaced by an empty one. If the file can't be used, nothing is cached, and the
// failure is reported once. If the failure is a full disk, the file is also removed. The file does
// not grow beyond k_motions_file_bytes_max. Motions belong to one request and one program version,
// because programs with the same results version may read states differently. Checksums are salted
// with the request and the version, so that no program uses another version's motions.
//
// Thread safety: one thread at a time; several processes may share one file.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>

#include "common/archive/remembering_reader.h"

namespace sleight::store {

/// When pending motions have this size, they are written.
inline constexpr std::size_t k_motions_bytes = 8U << 20U;
/// Maximum size of the file. A file of this size has some 20,000 motions of ten balls. Later
/// motions are not cached.
inline constexpr std::uint64_t k_motions_file_bytes_max = std::uint64_t{2} << 30U;

class StoredMotions final : public archive::Motions {
 public:
  /// Opens or creates the file. `owner`: a text of everything on which motions depend, except the
  /// state. Motions with another owner count as damaged, and are replaced when they are simulated
  /// again.
  StoredMotions(const std::string& folder, const std::string& owner,
                std::uint64_t file_bytes_max = k_motions_file_bytes_max);
  /// Writes pending motions if possible.
  ~StoredMotions() override;
  StoredMotions(const StoredMotions&) = delete;
  StoredMotions& operator=(const StoredMotions&) = delete;

  std::optional<archive::Motion> find(base::BytesView state) override;
  void keep(base::BytesView state, const archive::Motion& motion) override;

  static std::string path(const std::string& folder) { return folder + "/motions.sqlite"; }

 private:
  struct File;
  std::optional<archive::Motion> read(base::BytesView state);
  void write();
  /// Calls `act`. If the file is damaged, replaces it by an empty one and calls `act` again.
  void attempt(const std::function<void()>& act);
  void remove_file();
  void give_up(const std::string& reason);

  std::string path_;
  std::uint64_t salt_;
  std::uint64_t file_bytes_max_;
  bool is_usable_ = true;  ///< false: nothing is cached
  bool is_full_ = false;   ///< true: nothing more is cached
  std::unique_ptr<File> file_;
  std::map<std::string, archive::Motion> waiting_{};  ///< by state
  std::size_t waiting_bytes_ = 0;
};

}  // namespace sleight::store
