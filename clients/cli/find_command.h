// `sleight find`: the animations of archives that a query means.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "clients/browse/archives/browsed.h"

namespace sleight::cli {

struct FindOptions {
  std::vector<std::string> paths{};
  browse::QueryOptions asked{};
  std::string sort{};       ///< a number's name; empty: in the archives' order
  bool descending = false;  ///< the greatest first
  std::uint64_t limit = 0;  ///< at most so many; 0: all
  bool names = false;       ///< list what queries can speak of instead
  bool ids = false;         ///< names alone
  bool json = false;
};

/// Returns the exit code; throws base::Error.
int find_animations(const FindOptions& options);

}  // namespace sleight::cli
