// Checks that a fetched archive is the one that the job wrote. The transfer's checksum only covers
// the file on the server's disk, where it may have been damaged.
#pragma once

#include <string>

#include "common/rpc/service.h"

namespace sleight::service_client {

/// Verifies the file (archive/digest/verify.h), and compares its digest with a finished job's
/// digest. Prints what is wrong to stderr and throws base::Error (bad_archive). REQUIRES: no other
/// thread runs, because a child process reads the file.
void check_archive(const std::string& path, const rpc::JobView& job);

}  // namespace sleight::service_client
