// Leases (lease.h) as files of a folder on a disk that machines share, and what a machine knows of
// its processes.
//
// A lease's file is written whole under a name of its own, then linked to `lease.N`: link(2) makes
// a name for one process alone on every kind of network disk that has links, and O_EXCL on those
// that have none (some FUSE and SMB). A server's answer may be lost: whose file it is, the file
// tells.
//
// Thread safety: as Lease's.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/store/lease.h"

namespace sleight::store {

/// This process, as its machine knows it; the time is now.
LeaseHolder this_process();

/// Never the same twice.
std::string make_token();

class PosixLeaseFiles final : public LeaseFiles {
 public:
  /// `self`: this process, or what a test says that it is.
  PosixLeaseFiles(std::string folder, LeaseHolder self);

  std::vector<std::uint64_t> list() override;
  std::optional<std::string> read(std::uint64_t generation) override;
  std::unique_ptr<Own> make(std::uint64_t generation, const std::string& text) override;
  void remove(std::uint64_t generation) override;
  bool is_gone(const LeaseHolder& holder) override;
  bool is_here(const LeaseHolder& holder) override;

  /// Whether a folder has a lease that its holder has not let go.
  static bool any_held(const std::string& folder);

 private:
  std::string path_of(std::uint64_t generation) const;

  std::string folder_;
  LeaseHolder self_;
};

}  // namespace sleight::store
