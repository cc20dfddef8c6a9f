#include "common/base/check.h"

#include <cstdio>
#include <cstdlib>

namespace sleight::base {

void check_failed(std::string_view condition, std::string_view operands, const char* file,
                  int line) {
  const std::string message =
      fmt::format("{}:{}: check failed: {} ({})\n", file, line, condition, operands);
  std::fputs(message.c_str(), stderr);
  std::fflush(stderr);
  std::abort();
}

}  // namespace sleight::base
