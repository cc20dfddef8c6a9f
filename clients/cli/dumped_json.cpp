#include "clients/cli/dumped_json.h"

#include <nlohmann/json.hpp>

namespace sleight::cli {

std::string dumped(const nlohmann::ordered_json& json) {
  return json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

}  // namespace sleight::cli
