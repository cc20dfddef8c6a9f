#include "common/base/network_disk.h"

#include <sys/vfs.h>

#include <array>
#include <cstdlib>
#include <string_view>
#include <utility>

namespace sleight::base {
namespace {

// Magic numbers of file systems. Sources: statfs(2), and the source code of Lustre and GPFS.
constexpr std::array<std::pair<unsigned long, const char*>, 9> k_types{{{0x6969, "NFS"},
                                                                        {0x517B, "SMB"},
                                                                        {0xFF534D42, "SMB"},
                                                                        {0xFE534D42, "SMB"},
                                                                        {0x0BD00BD0, "Lustre"},
                                                                        {0x47504653, "GPFS"},
                                                                        {0x00C36400, "Ceph"},
                                                                        {0x65735546, "FUSE"},
                                                                        {0x01021997, "9P"}}};

std::optional<std::string> network_file_system_of_type(unsigned long type) {
  for (const auto& [known, name] : k_types) {
    if (known == type) return name;
  }
  return std::nullopt;
}

}  // namespace

std::optional<std::string> network_file_system(const std::string& path) {
  const char* const variable = std::getenv(k_network_disk_variable);
  const std::string_view said = variable != nullptr ? variable : "";
  if (said == "0") return std::nullopt;
  struct statfs found {};
  if (::statfs(path.c_str(), &found) != 0) return std::nullopt;
  const auto known =
      network_file_system_of_type(static_cast<unsigned long>(found.f_type) & 0xFFFFFFFFUL);
  if (!known && said == "1") return k_network_disk_variable;
  return known;
}

}  // namespace sleight::base
