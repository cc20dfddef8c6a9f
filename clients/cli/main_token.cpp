#include "clients/cli/main_token.h"

#include <memory>

#include "clients/cli/login_command.h"
#include "clients/cli/main_service.h"
#include "clients/cli/number_in.h"
#include "clients/cli/token_commands.h"

namespace sleight::programs {
namespace {

using Action = std::function<int()>;

constexpr std::uint32_t k_limit_max = 1'000'000;
const char* const k_token_json_help = "Print JSON";

void add_create(CLI::App& token, Action& action) {
  const auto options = std::make_shared<cli::TokenCreateOptions>();
  CLI::App* command = token.add_subcommand("create", "Create an access token and print it once");
  command->add_option("--name", options->name, "Descriptive name of the token")
      ->required()
      ->type_name("TEXT");
  command
      ->add_option("--scope", options->scopes,
                   "Permission: read, submit, manage or operate. Repeatable. Default: read, submit "
                   "and manage")
      ->allow_extra_args(false)
      ->type_name("SCOPE");
  command
      ->add_option("--expires", options->expires, "Time until the token expires: 90d, 12h or never")
      ->type_name("TIME")
      ->capture_default_str();
  command
      ->add_option(
          "--user", options->user,
          "Owner of the token. Default: you. Only the service's own user can name another user")
      ->type_name("USER");
  command
      ->add_option("--jobs", options->jobs_max,
                   "Maximum number of unfinished jobs for this token. Default: the user's limit")
      ->check(number_in(1U, k_limit_max))
      ->type_name("N");
  command
      ->add_option("--cores", options->cores_max,
                   "Maximum number of cores for each job of this token. Default: the user's limit")
      ->check(number_in(1U, k_limit_max))
      ->type_name("N");
  command
      ->add_option("-o,--output", options->output,
                   "New file for the token, readable only by its owner. Default: print the token")
      ->type_name("FILE");
  command->add_flag("--json", options->json, k_token_json_help);
  command->callback([&action, options] {
    action = [options] { return cli::create_token(service_called(), *options); };
  });
  command->footer(
      "A token permits its user the actions of its scopes: read (list, status, watch, logs,\n"
      "fetch), submit, manage (cancel, hold, resume, extend, delete, pin, priority) and operate\n"
      "(drain and stop the service). The service stores only a hash of the token.\n\n"
      "Examples:\n  sleight token create --name laptop -o laptop.token\n"
      "  sleight token create --name gallery --scope read --expires never\n"
      "  sleight token create --name render-farm --jobs 10 --cores 8");
}

void add_list_and_revoke(CLI::App& token, Action& action) {
  struct List {
    bool all = false;
    bool json = false;
  };
  const auto list = std::make_shared<List>();
  CLI::App* command = token.add_subcommand("list", "List valid tokens");
  command->add_flag("--all", list->all,
                    "Include tokens that were revoked or expired in the last 30 days");
  command->add_flag("--json", list->json, k_token_json_help);
  command->callback([&action, list] {
    action = [list] { return cli::list_tokens(service_called(), list->all, list->json); };
  });
  command->footer(
      "Examples:\n  sleight token list\n  sleight token list --json | jq '.[].last_used'");

  const auto revoked = std::make_shared<cli::TokenRevokeOptions>();
  command = token.add_subcommand("revoke", "Revoke tokens and end their sessions within a second");
  command->add_option("ids", revoked->ids, "Token id, from `sleight token list`")
      ->required()
      ->type_name("ID");
  command->add_flag("--json", revoked->json, k_token_json_help);
  command->callback([&action, revoked] {
    action = [revoked] { return cli::revoke_tokens(service_called(), *revoked); };
  });
  command->footer(
      "Jobs that were submitted with the token continue.\n\n"
      "Example:\n  sleight token revoke 7k2m9q4x1c");
}

void add_logins(CLI::App& app, Action& action) {
  const auto options = std::make_shared<cli::LoginOptions>();
  CLI::App* command = app.add_subcommand("login", "Log in to a service on another machine");
  command
      ->add_option("server", options->address,
                   "Host of the service, and its port. Default port: 7423")
      ->required()
      ->type_name("HOST:PORT");
  command
      ->add_option("--token-file", options->token_file,
                   "File with the token. Default: standard input")
      ->type_name("FILE");
  CLI::Option* fingerprint = command
                                 ->add_option("--fingerprint", options->fingerprint,
                                              "Fingerprint of the service's certificate, from "
                                              "`sleight server status` on the service's machine")
                                 ->type_name("SHA256:HEX");
  command
      ->add_option("--ca", options->ca_file,
                   "Certificate (PEM) of the authority that signed the service's certificate")
      ->excludes(fingerprint)
      ->type_name("FILE");
  command->add_flag("--json", options->json, k_token_json_help);
  command->callback([&action, options] { action = [options] { return cli::login(*options); }; });
  command->footer(
      "To create a token, run `sleight token create` on the service's machine. `sleight login`\n"
      "stores the token in ~/.config/sleight/servers, readable only by you. To send commands to\n"
      "that service, set SLEIGHT_SERVER, or `server` in config.toml.\n\n"
      "Examples:\n"
      "  sleight login render.example.org --fingerprint SHA256:4f0c... --token-file laptop.token\n"
      "  ssh render.example.org sleight token create --name laptop | sleight login "
      "render.example.org\n"
      "  SLEIGHT_SERVER=render.example.org sleight list");

  struct Logout {
    std::string address{};
    bool json = false;
  };
  const auto gone = std::make_shared<Logout>();
  command = app.add_subcommand("logout", "Delete the stored login of a service");
  command->add_option("server", gone->address, "Address, as given to `sleight login`")
      ->required()
      ->type_name("HOST:PORT");
  command->add_flag("--json", gone->json, k_token_json_help);
  command->callback(
      [&action, gone] { action = [gone] { return cli::logout(gone->address, gone->json); }; });
  command->footer("Example:\n  sleight logout render.example.org");
}

}  // namespace

void add_token_commands(CLI::App& app, Action& action) {
  CLI::App* token = app.add_subcommand("token", "Manage access tokens for use from other machines");
  token->require_subcommand(1);
  add_create(*token, action);
  add_list_and_revoke(*token, action);
  add_logins(app, action);
}

}  // namespace sleight::programs
