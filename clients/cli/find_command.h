// `sleight find`: lists the animations of archives that match a query.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "clients/browse/archives/browsed.h"

namespace sleight::cli {

struct FindOptions {
  std::vector<std::string> paths{};
  browse::QueryOptions asked{};
  std::string sort{};       ///< a number's name; empty: the archives' order
  bool descending = false;  ///< greatest first
  std::uint64_t limit = 0;  ///< maximum animations; 0: all
  bool names = false;       ///< list the names that queries can use instead
  bool ids = false;         ///< print only names
  bool json = false;
};

int find_animations(const FindOptions& options);

}  // namespace sleight::cli
