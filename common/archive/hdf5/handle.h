// Ownership and error checks for the HDF5 C API. Only this folder's sources include this header.
//
// Every result is checked by Api::id, Api::ok or Api::count. On failure, these functions throw a
// base::Error that names the file, the object and HDF5's innermost reason. HDF5 itself prints
// nothing. Plugins of HDF5 are disabled, because a file must not decide which code runs. HDF5's
// clean-up at exit is disabled: no object is open then, and the clean-up can crash after a failed
// write.
//
// HDF5 is one global library, so only one thread of the process may use this folder at a time.
#pragma once

#include <hdf5.h>

#include <cstdint>
#include <string>
#include <string_view>
#include <utility>

#include "common/base/error.h"

namespace sleight::archive::hdf5 {

/// An open HDF5 identifier with the function that closes it. Movable, not copyable.
class Handle {
 public:
  using Closer = herr_t (*)(hid_t);

  Handle() = default;
  Handle(hid_t id, Closer closer) : id_(id), closer_(closer) {}
  Handle(Handle&& other) noexcept { swap(other); }
  Handle& operator=(Handle&& other) noexcept {
    swap(other);
    return *this;
  }
  ~Handle() {
    if (closer_ != nullptr) closer_(id_);
  }

  hid_t get() const { return id_; }
  /// Closes the identifier and returns the closing function's result; 0 if nothing was open.
  herr_t close() {
    const Closer closer = std::exchange(closer_, nullptr);
    return closer == nullptr ? 0 : closer(id_);
  }

 private:
  void swap(Handle& other) noexcept {
    std::swap(id_, other.id_);
    std::swap(closer_, other.closer_);
  }
  hid_t id_ = H5I_INVALID_HID;
  Closer closer_ = nullptr;
};

/// Checks the results of HDF5 calls for one file.
class Api {
 public:
  /// Starts the library on first use. Errors about this file have `exit_code`.
  Api(std::string path, base::ExitCode exit_code);

  [[noreturn]] void fail(std::string_view object, std::string_view reason) const;

  /// `action` completes "can't ...". REQUIRES: called directly after the HDF5 function.
  Handle id(hid_t result, Handle::Closer closer, std::string_view object,
            std::string_view action) const;
  void ok(herr_t result, std::string_view object, std::string_view action) const {
    if (result < 0) fail_call(object, action);
  }
  /// Checks a count, size or truth value. HDF5 returns a negative number on failure.
  std::uint64_t count(std::int64_t result, std::string_view object, std::string_view action) const {
    if (result < 0) fail_call(object, action);
    return static_cast<std::uint64_t>(result);
  }

  const std::string& path() const { return path_; }

 private:
  [[noreturn]] void fail_call(std::string_view object, std::string_view action) const;

  std::string path_;
  base::ExitCode exit_code_;
};

}  // namespace sleight::archive::hdf5
