#include "clients/report/dumped_json.h"

namespace sleight::report {

std::string dumped(const json::Value& json) {
  return json.dump(2);
}

}  // namespace sleight::report
