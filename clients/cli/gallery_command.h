// `sleight gallery`: archives in the browser.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "clients/analysis/diagnosis.h"

namespace sleight::cli {

/// The port that is tried first, so that a gallery that is started again is found by its pages.
inline constexpr std::uint16_t k_usual_port = 8475;

struct CommandOptions {
  /// Archives, folders of archives, and jobs of the service ("17") where no file is called so.
  std::vector<std::string> paths{};
  std::uint16_t port = 0;            ///< 0: the usual one, or any that is free
  std::vector<std::string> hosts{};  ///< further names of this server in browsers: "localhost:8080"
  bool opens_browser = true;         ///< where there is a desktop
  bool json = false;                 ///< how it is reached, as one line of JSON
  std::string save{};  ///< a folder for a saved gallery, instead of serving; empty: none
};

/// `service_called`: the service's place, asked where there are jobs. Serves until Ctrl-C or
/// SIGTERM; returns the exit code. Throws base::Error. REQUIRES: no other thread runs.
int show_gallery(const CommandOptions& options, const std::function<std::string()>& service_called,
                 const analysis::Rules& rules);

}  // namespace sleight::cli
