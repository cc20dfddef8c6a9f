#include "clients/cli/dumped_json.h"

#include "common/json/value.h"

namespace sleight::cli {

std::string dumped(const json::Value& json) {
  return json.dump(2);
}

}  // namespace sleight::cli
