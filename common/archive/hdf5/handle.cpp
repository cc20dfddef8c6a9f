#include "common/archive/hdf5/handle.h"

#include <fmt/format.h>

#include <new>

#include "common/base/memory.h"

namespace sleight::archive::hdf5 {
namespace {

constexpr std::size_t k_start_bytes = 32U << 20U;

/// Returns the innermost message of HDF5's error stack, which names the cause, and clears the
/// stack. Throws std::bad_alloc if the cause is lack of memory.
std::string innermost_reason() {
  struct Found {
    std::string reason{};
    bool is_memory = false;
  } found;
  H5Ewalk2(
      H5E_DEFAULT, H5E_WALK_UPWARD,
      [](unsigned depth, const H5E_error2_t* error, void* out) -> herr_t {
        if (depth != 0) return 0;
        Found& innermost = *static_cast<Found*>(out);
        if (error->desc != nullptr) innermost.reason = error->desc;
        innermost.is_memory = error->maj_num == H5E_RESOURCE && error->min_num == H5E_NOSPACE;
        return 0;
      },
      &found);
  H5Eclear2(H5E_DEFAULT);
  if (found.is_memory) throw std::bad_alloc();
  return found.reason.empty() ? "HDF5 reported no reason" : found.reason;
}

/// If memory is short, H5open() can crash. So this function first checks that some memory is left.
bool start_library() {
  base::require_memory(k_start_bytes);
  return H5dont_atexit() >= 0 && H5open() >= 0 &&
         H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr) >= 0 && H5PLset_loading_state(0) >= 0;
}

}  // namespace

Api::Api(std::string path, base::ExitCode exit_code)
    : path_(std::move(path)), exit_code_(exit_code) {
  static const bool started = start_library();
  if (!started) throw base::Error(base::ExitCode::bug, "can't start the HDF5 library");
}

void Api::fail(std::string_view object, std::string_view reason) const {
  throw base::Error(exit_code_, object.empty() ? fmt::format("{}: {}", path_, reason)
                                               : fmt::format("{}: {}: {}", path_, object, reason));
}

void Api::fail_call(std::string_view object, std::string_view action) const {
  fail(object, fmt::format("can't {}: {}", action, innermost_reason()));
}

Handle Api::id(hid_t result, Handle::Closer closer, std::string_view object,
               std::string_view action) const {
  if (result < 0) fail_call(object, action);
  return {result, closer};
}

}  // namespace sleight::archive::hdf5
