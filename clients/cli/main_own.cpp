#include "clients/cli/main_own.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <system_error>
#include <vector>

#include "clients/cli/main_run.h"
#include "clients/cli/main_settings.h"
#include "clients/command_tree/command_tree.h"
#include "clients/command_tree/completion.h"
#include "clients/command_tree/man_page.h"
#include "common/base/error.h"
#include "common/base/file_system.h"
#include "common/config/settings.h"
#include "common/json/value.h"

namespace sleight::programs {
namespace {

/// Returns "default" or a setting's source. If the source is the settings file, returns "file" and
/// the line number. The file's path is printed below all settings.
std::string source_of(const config::Row& row, const std::optional<std::string>& path) {
  if (row.origin == config::Origin::fallback) return "default";
  if (row.origin == config::Origin::file && path && row.given_by.starts_with(*path))
    return "file" + row.given_by.substr(path->size());
  return row.given_by;
}

json::Value value_of(const config::Row& row) {
  if (row.is_text) return row.value;
  if (row.is_flag) return row.value == "true";
  if (!row.number) return nullptr;
  if (*row.number == std::floor(*row.number)) return static_cast<std::int64_t>(*row.number);
  return *row.number;
}

void print_json(const std::vector<config::Row>& rows, const std::optional<std::string>& path,
                bool is_there) {
  json::Value settings = json::Value::object();
  for (const config::Row& row : rows) {
    settings[row.key] = {{"value", value_of(row)},
                         {"unit", row.unit},
                         {"from", config::name_of(row.origin)},
                         {"given_by", row.given_by}};
  }
  const json::Value json{
      {"file", path.value_or("")}, {"file_is_there", is_there}, {"settings", settings}};
  fmt::print("{}\n", json.dump(2));
}

/// Prints a table (with `json`: an object) and returns the exit code. Throws base::Error(usage)
/// that lists every error in the environment and the file.
int print_config(bool json) {
  const config::Settings settings = config::settings_here();
  const std::vector<config::Row> rows = config::rows_of(settings);
  const std::optional<std::string> path = config::config_path_of(config::surroundings_here());
  std::error_code none;
  const bool is_there = path && std::filesystem::exists(*path, none);
  if (json) {
    print_json(rows, path, is_there);
    return 0;
  }
  std::size_t key_width = 0;
  std::size_t value_width = 0;
  std::size_t source_width = 0;
  for (const config::Row& row : rows) {
    key_width = std::max(key_width, row.key.size());
    value_width = std::max(value_width, row.value.size());
    source_width = std::max(source_width, source_of(row, path).size());
  }
  for (const config::Row& row : rows) {
    fmt::print("{:<{}}  {:<{}}  {:<{}}  {}\n", row.key, key_width, row.value, value_width,
               source_of(row, path), source_width, row.help);
  }
  if (path) fmt::print("\nSettings file: {}{}\n", *path, is_there ? "" : " (does not exist)");
  return 0;
}

/// Programs that have completion scripts and manual pages.
constexpr std::array<const char*, 3> k_programs{"sleight", "sleight-batch", "sleightd"};

command_tree::Command tree_of_program(const std::string& name) {
  CLI::App app;
  CommandLine line;
  DirectArguments arguments;
  std::vector<config::Given> given;
  if (name == k_programs[0]) {
    build_app(app, line);
  } else if (name == k_programs[1]) {
    build_batch_app(app, arguments);
  } else {
    build_daemon_app(app, given);
  }
  return command_tree::tree_of(app);
}

int print_completion(const std::string& shell, const std::string& program) {
  const command_tree::Command tree = tree_of_program(program);
  fmt::print("{}", shell == "bash"  ? command_tree::bash_completion(tree)
                   : shell == "zsh" ? command_tree::zsh_completion(tree)
                                    : command_tree::fish_completion(tree));
  return static_cast<int>(base::ExitCode::ok);
}

/// Returns a date such as "November 26, 2026". The date is today's. If SOURCE_DATE_EPOCH is set, it
/// is used instead, so that packages are reproducible.
std::string page_date() {
  using std::chrono::system_clock;
  system_clock::time_point moment = system_clock::now();
  if (const char* epoch = std::getenv("SOURCE_DATE_EPOCH"))
    moment = system_clock::time_point(std::chrono::seconds(std::strtoll(epoch, nullptr, 10)));
  const std::chrono::year_month_day day{std::chrono::floor<std::chrono::days>(moment)};
  static constexpr std::array<const char*, 12> k_months{
      "January", "February", "March",     "April",   "May",      "June",
      "July",    "August",   "September", "October", "November", "December"};
  return fmt::format("{} {}, {}", k_months.at(unsigned{day.month()} - 1), unsigned{day.day()},
                     int{day.year()});
}

int write_man_pages(const std::string& folder) {
  if (folder.empty()) {
    const auto pages = command_tree::man_pages(tree_of_program(k_programs[0]), page_date());
    fmt::print("{}", pages.front().text);
    return static_cast<int>(base::ExitCode::ok);
  }
  std::error_code failure;
  std::filesystem::create_directories(folder, failure);
  if (failure) throw base::Error(fmt::format("{}: {}", folder, failure.message()));
  base::PosixFileSystem files;
  for (const char* program : k_programs) {
    for (const auto& page : command_tree::man_pages(tree_of_program(program), page_date()))
      base::write_text_file(files, folder + "/" + page.file, page.text);
  }
  return static_cast<int>(base::ExitCode::ok);
}

void add_config(CLI::App& app, OwnArguments& arguments, Action& action) {
  CLI::App* command =
      app.add_subcommand("config", "List the service's settings and the source of each");
  command->add_flag("--json", arguments.json, "Print JSON");
  command->footer(
      "Sources, highest priority first: the command line; the environment (SLEIGHT_STATE,\n"
      "SLEIGHT_SOCKET, SLEIGHT_SERVER, SLEIGHT_ALLOW_ROOT); the file\n"
      "$XDG_CONFIG_HOME/sleight/config.toml (without XDG_CONFIG_HOME:\n"
      "~/.config/sleight/config.toml); defaults.\n\n"
      "The file is TOML with the listed keys. For example, `limits.jobs` is the key `jobs` in\n"
      "section [limits].\n\n"
      "Examples:\n  sleight config\n  sleight config --json | jq .settings.state.value");
  command->callback([&] { action = [&] { return print_config(arguments.json); }; });
}

void add_completion(CLI::App& app, OwnArguments& arguments, Action& action) {
  CLI::App* command = app.add_subcommand("completion", "Print a shell's completion script");
  command->add_option("shell", arguments.shell, "Shell to complete in")
      ->required()
      ->check(CLI::IsMember({"bash", "zsh", "fish"}))
      ->type_name("SHELL");
  command->add_option("program", arguments.program, "Program to complete")
      ->check(CLI::IsMember(std::vector<std::string>(k_programs.begin(), k_programs.end())))
      ->capture_default_str()
      ->type_name("PROGRAM");
  command->footer(
      "Load the script in the shell's start-up file. In zsh, load the script after compinit.\n\n"
      "Examples:\n  source <(sleight completion bash)\n  source <(sleight completion zsh)\n"
      "  sleight completion fish | source\n"
      "  sleight completion bash sleight-batch > "
      "~/.local/share/bash-completion/completions/sleight-batch");
  command->callback(
      [&] { action = [&] { return print_completion(arguments.shell, arguments.program); }; });
}

void add_man(CLI::App& app, OwnArguments& arguments, Action& action) {
  CLI::App* command = app.add_subcommand("man", "Print the manual page or write all pages");
  command->group("");  // hidden, because people use `man sleight`
  command
      ->add_option("--directory", arguments.folder,
                   "Write the manual pages of all programs to this folder")
      ->type_name("FOLDER");
  command->footer("Examples:\n  sleight man | man -l -\n  sleight man --directory share/man/man1");
  command->callback([&] { action = [&] { return write_man_pages(arguments.folder); }; });
}

}  // namespace

void add_own_commands(CLI::App& app, OwnArguments& arguments, Action& action) {
  add_config(app, arguments, action);
  add_completion(app, arguments, action);
  add_man(app, arguments, action);
}

}  // namespace sleight::programs
