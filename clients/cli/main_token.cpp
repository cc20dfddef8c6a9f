#include "clients/cli/main_token.h"

#include <limits>
#include <memory>

#include "clients/cli/login_command.h"
#include "clients/cli/main_service.h"
#include "clients/cli/token_commands.h"

namespace sleight::programs {
namespace {

using Action = std::function<int()>;

constexpr std::uint32_t k_limit_max = 1'000'000;
const char* const k_token_json_help = "As JSON";

void add_create(CLI::App& token, Action& action) {
  const auto options = std::make_shared<cli::TokenCreateOptions>();
  CLI::App* command = token.add_subcommand("create", "Make one, and show it this once");
  command->add_option("--name", options->name, "For people: what it is for")
      ->required()
      ->type_name("TEXT");
  command
      ->add_option("--scope", options->scopes,
                   "What it is for; may be given repeatedly (read, submit, manage, operate); read, "
                   "submit and manage if not given")
      ->allow_extra_args(false)
      ->type_name("SCOPE");
  command->add_option("--expires", options->expires, "After so long: 90d, 12h, or never")
      ->type_name("TIME")
      ->capture_default_str();
  command
      ->add_option("--user", options->user,
                   "User who owns the token; only the service's own user may name another")
      ->type_name("USER");
  command->add_option("--jobs", options->jobs_max, "Most unfinished jobs that it may have at once")
      ->check(CLI::Range(1U, k_limit_max))
      ->type_name("N");
  command->add_option("--cores", options->cores_max, "Most cores for each of its jobs")
      ->check(CLI::Range(1U, k_limit_max))
      ->type_name("N");
  command->add_option("-o,--output", options->output, "Into this new file, for its owner alone")
      ->type_name("FILE");
  command->add_flag("--json", options->json, k_token_json_help);
  command->callback([&action, options] {
    action = [options] { return cli::create_token(service_called(), *options); };
  });
  command->footer(
      "A token does what its user may, as far as its scopes go: read (list, status, watch, logs,\n"
      "fetch), submit, manage (cancel, hold, resume, extend, delete, pin, priority), operate "
      "(drain "
      "and\nstop the service). The service keeps its hash alone.\n\n"
      "Examples:\n"
      "  sleight token create --name laptop -o laptop.token\n"
      "  sleight token create --name gallery --scope read --expires never\n"
      "  sleight token create --name render-farm --jobs 10 --cores 8");
}

void add_list_and_revoke(CLI::App& token, Action& action) {
  struct List {
    bool all = false;
    bool json = false;
  };
  const auto list = std::make_shared<List>();
  CLI::App* command = token.add_subcommand("list", "Those that are valid");
  command->add_flag("--all", list->all,
                    "Also those that were revoked or have expired, for 30 days");
  command->add_flag("--json", list->json, k_token_json_help);
  command->callback([&action, list] {
    action = [list] { return cli::list_tokens(service_called(), list->all, list->json); };
  });
  command->footer(
      "Examples:\n  sleight token list\n  sleight token list --json | jq '.[].last_used'");

  const auto revoked = std::make_shared<cli::TokenRevokeOptions>();
  command = token.add_subcommand("revoke", "End them, and their sessions within a second");
  command->add_option("ids", revoked->ids, "As `sleight token list` shows them")
      ->required()
      ->type_name("ID");
  command->add_flag("--json", revoked->json, k_token_json_help);
  command->callback([&action, revoked] {
    action = [revoked] { return cli::revoke_tokens(service_called(), *revoked); };
  });
  command->footer(
      "Jobs that were submitted by it go on.\n\nExample:\n  sleight token revoke 7k2m9q4x1c");
}

void add_logins(CLI::App& app, Action& action) {
  const auto options = std::make_shared<cli::LoginOptions>();
  CLI::App* command = app.add_subcommand("login", "Use a service of another machine");
  command->add_option("server", options->address, "Its host, and its port if that isn't 7423")
      ->required()
      ->type_name("HOST:PORT");
  command
      ->add_option("--token-file", options->token_file,
                   "Where its token is; standard input if not given")
      ->type_name("FILE");
  CLI::Option* fingerprint =
      command
          ->add_option("--fingerprint", options->fingerprint,
                       "Of its certificate, as `sleight server status` there says")
          ->type_name("SHA256:HEX");
  command->add_option("--ca", options->ca_file, "Of the authority that vouches for it, in PEM")
      ->excludes(fingerprint)
      ->type_name("FILE");
  command->add_flag("--json", options->json, k_token_json_help);
  command->callback([&action, options] { action = [options] { return cli::login(*options); }; });
  command->footer(
      "On the service's machine `sleight token create` makes the token. It is kept in\n"
      "~/.config/sleight/servers, for you alone. Afterwards SLEIGHT_SERVER, or `server` in\n"
      "config.toml, says that commands are for that service.\n\n"
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
  command = app.add_subcommand("logout", "Forget a service of another machine");
  command->add_option("server", gone->address, "As it was logged in to")
      ->required()
      ->type_name("HOST:PORT");
  command->add_flag("--json", gone->json, k_token_json_help);
  command->callback(
      [&action, gone] { action = [gone] { return cli::logout(gone->address, gone->json); }; });
  command->footer("Example:\n  sleight logout render.example.org");
}

}  // namespace

void add_token_commands(CLI::App& app, Action& action) {
  CLI::App* token = app.add_subcommand("token", "Who may call the service from other machines");
  token->require_subcommand(1);
  add_create(*token, action);
  add_list_and_revoke(*token, action);
  add_logins(app, action);
}

}  // namespace sleight::programs
