#include "common/rpc/event_descriptor.h"

#include <sys/eventfd.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>

#include "common/base/error.h"

namespace sleight::rpc {

kj::AutoCloseFd make_event_descriptor() {
  const int descriptor = ::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
  if (descriptor < 0) {
    throw base::Error("can't create an event descriptor: " + std::system_category().message(errno) +
                      "; raise the limit of open files (ulimit -n)");
  }
  return kj::AutoCloseFd(descriptor);
}

std::uint64_t drain_events(int descriptor) {
  std::uint64_t count = 0;
  return ::read(descriptor, &count, sizeof count) == sizeof count ? count : 0;
}

}  // namespace sleight::rpc
