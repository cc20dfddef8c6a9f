// Whether an archive that came from the service is the one that the job wrote. The transport's own
// checksum is of the file as it lies on the server's disk, where it may have been damaged.
#pragma once

#include <string>

#include "common/rpc/service.h"

namespace sleight::service_client {

/// Verifies the file (archive/digest/verify.h), and that a finished job's has the job's digest.
/// Says on stderr what is wrong, and throws base::Error (bad_archive). REQUIRES: no other thread
/// runs, as it reads in a child.
void check_archive(const std::string& path, const rpc::JobView& job);

}  // namespace sleight::service_client
