// Ownership and error checks for the HDF5 C API; included by this folder's sources alone.
//
// Every call's result goes through Api::id, Api::ok or Api::count, which turn a failure into a
// base::Error that names the file, the object and HDF5's innermost reason. HDF5 itself prints
// nothing, loads no plugins (a file must not choose code for us to run) and does not clean up at
// exit (nothing of ours is open then, and after a failed write its clean-up can crash).
//
// HDF5 is one global library: all of this folder is for one thread at a time in the process.
#pragma once

#include <hdf5.h>

#include <cstdint>
#include <string>
#include <string_view>
#include <utility>

#include "common/base/error.h"

namespace sleight::archive::hdf5 {

/// An open HDF5 identifier with the function that closes it. A resource: moves, does not copy.
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
  /// Closes now and gives the function's result; 0 when nothing was open.
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

/// Checks results on behalf of one file.
class Api {
 public:
  /// Starts the library on first use. `exit_code`: what a failure means for this file.
  Api(std::string path, base::ExitCode exit_code);

  [[noreturn]] void fail(std::string_view object, std::string_view reason) const;

  /// `action` completes "can't ...". REQUIRES: called right after the HDF5 function.
  Handle id(hid_t result, Handle::Closer closer, std::string_view object,
            std::string_view action) const;
  void ok(herr_t result, std::string_view object, std::string_view action) const {
    if (result < 0) fail_call(object, action);
  }
  /// For functions that give a count, a size or a truth value, negative on failure.
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
