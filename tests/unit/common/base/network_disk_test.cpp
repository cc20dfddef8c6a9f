#include "common/base/network_disk.h"

#include <gtest/gtest.h>

#include <optional>

namespace sleight::base {
namespace {

TEST(NetworkDisk, KnowsTheTypes) {
  // Goal: each network file system is known by what statfs says, and local ones are none. Method:
  // the numbers of statfs(2): NFS, CIFS, Lustre, GPFS, Ceph, FUSE; ext4, xfs, btrfs, tmpfs,
  // overlay.
  EXPECT_EQ(network_file_system_of_type(0x6969), "NFS");
  EXPECT_EQ(network_file_system_of_type(0xFF534D42), "SMB");
  EXPECT_EQ(network_file_system_of_type(0x0BD00BD0), "Lustre");
  EXPECT_EQ(network_file_system_of_type(0x47504653), "GPFS");
  EXPECT_EQ(network_file_system_of_type(0x00C36400), "Ceph");
  EXPECT_EQ(network_file_system_of_type(0x65735546), "FUSE");
  for (const unsigned long local :
       {0xEF53UL, 0x58465342UL, 0x9123683EUL, 0x01021994UL, 0x794c7630UL})
    EXPECT_EQ(network_file_system_of_type(local), std::nullopt);
}

TEST(NetworkDisk, PathsOfThisMachineAreLocal) {
  // Goal: what the kernel makes up is no network disk, and no path is no error. Method: /proc,
  // tmpfs, a path that is not there.
  EXPECT_EQ(network_file_system("/proc"), std::nullopt);
  EXPECT_EQ(network_file_system("/dev/shm"), std::nullopt);
  EXPECT_EQ(network_file_system("/no/such/path"), std::nullopt);
}

}  // namespace
}  // namespace sleight::base
