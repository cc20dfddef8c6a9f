#include "clients/terminal/dumped_json.h"

#include "common/json/value.h"

namespace sleight::terminal {

std::string dumped(const json::Value& json) {
  return json.dump(2);
}

}  // namespace sleight::terminal
