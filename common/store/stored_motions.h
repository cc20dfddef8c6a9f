// Motions of kept animations, remembered beside a run's store: `motions.sqlite` in its folder.
//
// It is no part of the run: it may be deleted at any time, and what it has lost or got wrong is
// simulated again. So nothing waits for the disk, every row carries a checksum, and a file that is
// damaged is made anew. Where it can't be used nothing is remembered, which is said once; a full
// disk also gets its space back. It does not grow beyond k_motions_file_bytes_max. Motions belong
// to one request and one program version, since a results version does not cover readers: checksums
// are salted with these, so that no program takes another one's motions.
//
// Thread safety: one thread at a time; several processes may have one file.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/archive/remembering_reader.h"

namespace sleight::store {

/// Motions are written when so many bytes wait.
inline constexpr std::size_t k_motions_bytes = 8U << 20U;
/// What comes later is not remembered: some 20,000 motions of ten balls.
inline constexpr std::uint64_t k_motions_file_bytes_max = std::uint64_t{2} << 30U;

class StoredMotions final : public archive::Motions {
 public:
  /// Opens or makes the file. `owner`: what the motions hang on besides the state, as text; those
  /// of another owner are taken for damaged, and replaced as they are simulated again.
  StoredMotions(const std::string& folder, const std::string& owner,
                std::uint64_t file_bytes_max = k_motions_file_bytes_max);
  /// Writes what waits, if it can.
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
  /// Does it; where the file turns out to be damaged, makes it anew and does it once more.
  void attempt(const std::function<void()>& act);
  void remove_file();
  void give_up(const std::string& reason);

  std::string path_;
  std::uint64_t salt_;
  std::uint64_t file_bytes_max_;
  bool is_usable_ = true;  ///< false: nothing is remembered
  bool is_full_ = false;   ///< nothing more is
  std::unique_ptr<File> file_;
  std::map<std::string, archive::Motion> waiting_{};  ///< by state
  std::size_t waiting_bytes_ = 0;
};

}  // namespace sleight::store
