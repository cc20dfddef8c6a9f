// Which results this program makes: two programs with one results version can go on with one
// another's runs, and compute on one run together.
#pragma once

#include <string_view>

namespace sleight::programs {

/// A hash of the sources and flags that decide what a run stores, 16 hex digits (deploy/version
/// --results). Other sources, such as those of clients, readers and documents, don't change it.
std::string_view results_version();

}  // namespace sleight::programs
