#include "common/archive/hdf5/handle.h"

#include <fmt/format.h>

namespace sleight::archive::hdf5 {
namespace {

/// What was wrong at the bottom of HDF5's error stack, where the cause is; then empties the stack.
std::string innermost_reason() {
  std::string reason;
  H5Ewalk2(
      H5E_DEFAULT, H5E_WALK_UPWARD,
      [](unsigned depth, const H5E_error2_t* error, void* out) -> herr_t {
        if (depth == 0 && error->desc != nullptr) *static_cast<std::string*>(out) = error->desc;
        return 0;
      },
      &reason);
  H5Eclear2(H5E_DEFAULT);
  return reason.empty() ? "HDF5 gives no reason" : reason;
}

bool start_library() {
  return H5dont_atexit() >= 0 && H5open() >= 0 &&
         H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr) >= 0 && H5PLset_loading_state(0) >= 0;
}

}  // namespace

Api::Api(std::string path, base::ExitCode exit_code)
    : path_(std::move(path)), exit_code_(exit_code) {
  static const bool started = start_library();
  if (!started) throw base::Error(base::ExitCode::bug, "the HDF5 library can't be started");
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
