// `sleight gallery`: shows archives in the browser.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "clients/analysis/diagnosis.h"

namespace sleight::cli {

/// The default port is tried first, so that open pages find a restarted gallery.
inline constexpr std::uint16_t k_usual_port = 8475;

struct CommandOptions {
  /// Archives, folders of archives, or jobs of the service. "17" is a job if no file has that name.
  std::vector<std::string> paths{};
  std::uint16_t port = 0;            ///< 0: the default port, or any free one
  std::vector<std::string> hosts{};  ///< further names of this server, such as "localhost:8080"
  bool opens_browser = true;         ///< only with a desktop
  bool json = false;                 ///< print how to reach the server as one line of JSON
  std::string save{};                ///< folder for a saved gallery instead of serving; empty: none
};

/// `service_called` returns the service's address. This function is called only if a job is named.
/// Serves until Ctrl-C or SIGTERM, then returns the exit code. Throws base::Error. REQUIRES: no
/// other thread runs.
int show_gallery(const CommandOptions& options, const std::function<std::string()>& service_called,
                 const analysis::Rules& rules);

}  // namespace sleight::cli
