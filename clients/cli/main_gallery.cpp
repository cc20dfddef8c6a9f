#include "clients/cli/main_gallery.h"

#include <charconv>
#include <cstdint>
#include <string>
#include <string_view>
#include <system_error>

#include <fmt/format.h>

#include "clients/cli/main_service.h"
#include "clients/cli/number_in.h"
#include "common/request/text.h"

namespace sleight::programs {
namespace {

constexpr std::size_t k_shown_characters_max = 80;

/// Returns why a text isn't a valid HOST:PORT. HOST is an IPv6 address in brackets, or letters,
/// digits, dots and dashes. Empty if it is valid.
std::string fault_of_host(const std::string& text) {
  const std::size_t colon = text.rfind(':');
  const std::string host = text.substr(0, colon);
  const std::string port = colon == std::string::npos ? std::string() : text.substr(colon + 1);
  const bool is_ipv6 = host.size() > 2 && host.front() == '[' && host.back() == ']';
  const std::string_view allowed =
      is_ipv6 ? "0123456789abcdefABCDEF:."
              : "0123456789abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ.-";
  const std::string name = is_ipv6 ? host.substr(1, host.size() - 2) : host;
  std::uint16_t number = 0;
  const auto [rest, failure] = std::from_chars(port.data(), port.data() + port.size(), number);
  const bool is_port = failure == std::errc() && rest == port.data() + port.size() && number != 0;
  if (is_port && !name.empty() && name.find_first_not_of(allowed) == std::string::npos) return {};
  return fmt::format("expected HOST:PORT, such as localhost:8080, found '{}'",
                     request::printable(text, k_shown_characters_max));
}

std::string fault_of_folder(const std::string& text) {
  return text.empty() ? "expected the name of a folder" : std::string();
}

}  // namespace

void add_gallery_command(CLI::App& app, cli::CommandOptions& options, const analysis::Rules& rules,
                         Action& action) {
  CLI::App* command = app.add_subcommand(
      "gallery", "Show archives in the browser, with all animations, a player and plots");
  command
      ->add_option("archives", options.paths,
                   "Archives, folders of archives, or jobs of the service")
      ->required()
      ->type_name("ARCHIVE.h5|FOLDER|JOB");
  command
      ->add_option(
          "--port", options.port,
          fmt::format("TCP port to listen on. Default: {}, or any free port", cli::k_usual_port))
      ->check(number_in(1, 65535).description(""))
      ->type_name("PORT");
  command
      ->add_option(
          "--host", options.hosts,
          "Another address at which browsers reach the gallery, such as localhost:8080 if ssh -L "
          "forwards port 8080. 127.0.0.1:PORT and localhost:PORT always work. Repeatable")
      ->allow_extra_args(false)
      ->check(CLI::Validator(fault_of_host, ""))
      ->type_name("HOST:PORT");
  command->add_flag_callback(
      "--no-browser", [&options] { options.opens_browser = false; },
      "Print the link without opening a browser");
  command
      ->add_option("--save", options.save,
                   "Write the gallery as a folder of static files and exit. Publish the folder, or "
                   "double-click its index.html. Replaces an earlier saved gallery")
      ->check(CLI::Validator(fault_of_folder, ""))
      ->type_name("FOLDER");
  command->add_flag("--json", options.json, "Print link, port and process id as one line of JSON");
  command->footer(
      "The gallery listens on this machine's loopback address only. The gallery's link\n"
      "works in one browser only, so other users of the machine cannot open the gallery. From\n"
      "another machine, run `ssh -L PORT:127.0.0.1:PORT HOST` and open the same link.\n\n"
      "The page updates when an archive changes and when a running job commits new animations.\n"
      "Stars, tags and notes are stored in ~/.local/share/sleight/notes, or in the folder\n"
      "\"sleight-notes\" beside the archive if that folder exists; never in an archive.\n\n"
      "Examples:\n  sleight gallery hi.h5\n"
      "  sleight gallery results/ --no-browser --port 9000\n"
      "  sleight gallery 17\n"
      "  sleight gallery hi.h5 --save hi_gallery\n"
      "  ssh -L 8475:127.0.0.1:8475 cluster sleight gallery runs/hi.h5 --no-browser");
  command->callback(
      [&] { action = [&] { return cli::show_gallery(options, service_called, rules); }; });
}

}  // namespace sleight::programs
