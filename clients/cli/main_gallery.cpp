#include "clients/cli/main_gallery.h"

#include <fmt/format.h>

#include "common/config/settings.h"

namespace sleight::programs {

void add_gallery_command(CLI::App& app, gallery::CommandOptions& options, const cli::Rules& rules,
                         Action& action) {
  CLI::App* command =
      app.add_subcommand("gallery", "Archives in the browser: a wall of animations, player, plots");
  command
      ->add_option("archives", options.paths,
                   "Archives, folders of archives, or jobs of the service")
      ->required()
      ->type_name("ARCHIVE.h5|FOLDER|JOB");
  command
      ->add_option(
          "--port", options.port,
          fmt::format("Listen there; without, on {} or any that is free", gallery::k_usual_port))
      ->check(CLI::Range(1, 65535).description(""))
      ->type_name("PORT");
  command
      ->add_option("--host", options.hosts,
                   "As a browser calls this gallery, where that isn't 127.0.0.1:PORT or "
                   "localhost:PORT: HOST:PORT of an ssh -L to another port")
      ->allow_extra_args(false)
      ->type_name("HOST:PORT");
  command->add_flag("!--no-browser", options.opens_browser, "Print the link and open nothing");
  command
      ->add_option("--save", options.save,
                   "Write the gallery as a folder of static files, to publish or to open by "
                   "double-click, and serve nothing")
      ->type_name("FOLDER");
  command->add_flag("--json", options.json, "The link, port and pid as one line of JSON");
  command->footer(
      "The gallery listens on this machine's loopback alone. Its link lets one browser in; others\n"
      "of this machine's users can't see anything. From another machine: ssh -L "
      "PORT:127.0.0.1:PORT\n"
      "HOST, then the same link. Archives that grow or are replaced are read anew by themselves;\n"
      "of a job that runs new animations come as they are committed.\n"
      "Stars, tags and notes are kept in ~/.local/share/sleight/notes, or beside the archive in a\n"
      "folder \"sleight-notes\" where there is one; never in an archive.\n\n"
      "Examples:\n"
      "  sleight gallery hi.h5\n"
      "  sleight gallery results/ --no-browser --port 9000\n"
      "  sleight gallery 17\n"
      "  sleight gallery hi.h5 --save hi_gallery\n"
      "  ssh -L 8475:127.0.0.1:8475 cluster sleight gallery runs/hi.h5 --no-browser");
  command->callback([&] {
    action = [&] {
      return gallery::show_gallery(options, config::settings_here().socket.value, rules);
    };
  });
}

}  // namespace sleight::programs
