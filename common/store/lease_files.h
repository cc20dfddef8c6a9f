// Implements LeaseFiles (lease.h). Leases are files in a folder on a shared disk. Also finds out
// whether processes of this machine are alive.
//
// A lease's file is written completely under a temporary name, then linked to `lease.N`. If a
// network disk has links, link(2) is exclusive. On other disks (some FUSE and SMB), O_EXCL is
// exclusive. The server's answer may be lost, so the file's content decides who created the file.
//
// Thread safety: as Lease.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/store/lease.h"

namespace sleight::store {

/// Returns this process as a holder, with the current time.
LeaseHolder this_process();

/// Returns a text that is different at each call.
std::string make_token();

class PosixLeaseFiles final : public LeaseFiles {
 public:
  /// `self`: this process, or another holder in tests.
  PosixLeaseFiles(std::string folder, LeaseHolder self);

  std::vector<std::uint64_t> list() override;
  std::optional<std::string> read(std::uint64_t generation) override;
  std::unique_ptr<Own> make(std::uint64_t generation, const std::string& text) override;
  void remove(std::uint64_t generation) override;
  bool is_gone(const LeaseHolder& holder) override;
  bool is_here(const LeaseHolder& holder) override;

  /// Returns whether the folder has a lease that was not released.
  static bool any_held(const std::string& folder);

 private:
  std::string path_of(std::uint64_t generation) const;

  std::string folder_;
  LeaseHolder self_;
};

}  // namespace sleight::store
