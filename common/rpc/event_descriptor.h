// A descriptor with which other threads and signal handlers wake a KJ event loop.
#pragma once

#include <kj/io.h>

#include <cstdint>

namespace sleight::rpc {

/// Returns a non-blocking eventfd that child processes don't inherit. Throws base::Error.
kj::AutoCloseFd make_event_descriptor();

/// Returns the sum of the numbers written to the descriptor since the last call. 0: none was
/// written.
std::uint64_t drain_events(int descriptor);

}  // namespace sleight::rpc
