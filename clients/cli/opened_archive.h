// What every command that reads an archive shares: how it is opened, and JSON of it.
//
// HDF5 reads it in a process of its own, which has given up everything else (archive/remote). What
// a command makes of the values is worked out in a guarded child of this process, as numbers of a
// hostile file may ask for any amount of memory or time.
#pragma once

#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "common/archive/model.h"

namespace sleight::cli {

/// Runs `work` on the opened archive, in a child that may crash or hang, and returns its exit code.
/// Throws what archive::hdf5::guarded and archive::remote::open_remote throw. REQUIRES: no other
/// thread runs.
int with_archive(const std::string& path, const std::function<int(const archive::Source&)>& work);

/// Indented text. A path need not be UTF-8; JSON must be, so what is not is replaced.
std::string dumped(const nlohmann::ordered_json& json);

}  // namespace sleight::cli
