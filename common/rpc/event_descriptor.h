// A descriptor by which other threads and signal handlers wake a KJ event loop.
#pragma once

#include <kj/io.h>

#include <cstdint>

namespace sleight::rpc {

/// An eventfd: not blocking, not inherited. Throws base::Error.
kj::AutoCloseFd make_event_descriptor();

/// What was written to it since it was last read; 0: nothing.
std::uint64_t drain_events(int descriptor);

}  // namespace sleight::rpc
