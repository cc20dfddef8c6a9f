#include "clients/cli/opened_archive.h"

#include <nlohmann/json.hpp>

#include "clients/cli/output.h"
#include "common/archive/hdf5/guarded.h"
#include "common/archive/remote/remote_source.h"

namespace sleight::cli {

int with_archive(const std::string& path, const std::function<int(const archive::Source&)>& work) {
  return archive::hdf5::guarded(path, {}, [&] {
    return with_results([&] { return work(*archive::remote::open_remote(path)); });
  });
}

std::string dumped(const nlohmann::ordered_json& json) {
  return json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

}  // namespace sleight::cli
