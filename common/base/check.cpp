#include "common/base/check.h"

#include <cstdio>
#include <cstdlib>

namespace sleight::base {

void check_failed(std::string_view condition, std::string_view operands,
                  const std::source_location& where) {
  const std::string line = fmt::format("{}:{}: check failed: {} ({})\n", where.file_name(),
                                       where.line(), condition, operands);
  std::fputs(line.c_str(), stderr);
  std::fflush(stderr);
  std::abort();
}

}  // namespace sleight::base
