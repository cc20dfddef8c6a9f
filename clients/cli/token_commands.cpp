#include "clients/cli/token_commands.h"

#include <fcntl.h>
#include <fmt/chrono.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <system_error>

#include "clients/cli/service_json.h"
#include "clients/report/report.h"
#include "clients/service_client/service_call.h"
#include "clients/terminal/output.h"
#include "clients/terminal/terminal.h"
#include "common/access/token_text.h"
#include "common/base/descriptor.h"
#include "common/base/error.h"
#include "common/config/quantities.h"

namespace sleight::cli {
namespace {

constexpr double k_day_s = 86400;

std::vector<std::string> names_of(const rpc::Scopes& scopes) {
  std::vector<std::string> names;
  for (const rpc::Scope scope : rpc::k_scopes)
    if (scopes.has(scope)) names.emplace_back(rpc::name_of(scope));
  return names;
}

std::string day_of(double time_s) {
  return fmt::format("{:%Y-%m-%d %H:%M}", fmt::localtime(static_cast<std::time_t>(time_s)));
}

std::string state_of_token(const rpc::TokenView& token) {
  if (token.revoked_s > 0) return "revoked";
  return token.has_expired ? "expired" : "valid";
}

report::Report report_of(const rpc::TokenView& token) {
  const auto or_null = [](double time_s) { return time_s > 0 ? Json(time_s) : Json(nullptr); };
  const auto limit = [](std::uint32_t count) { return count > 0 ? Json(count) : Json(nullptr); };
  const auto day = [](double time_s) { return time_s > 0 ? day_of(time_s) : std::string("never"); };
  using report::Column;
  const std::vector<std::string> scopes = names_of(token.scopes);
  report::Report report;
  report.add("id", token.id, Column{.head = "ID"}, terminal::shown(token.id));
  report.add("user", token.user, Column{.head = "USER", .rank = 3},
             terminal::name_of_user(token.user));
  report.add("state", state_of_token(token), Column{.head = "STATE"}, state_of_token(token));
  report.add("scopes", scopes, Column{.head = "SCOPES", .rank = 1},
             fmt::format("{}", fmt::join(scopes, " ")));
  report.for_programs("created", token.created_s);
  report.add("expires", or_null(token.expires_s), Column{.head = "EXPIRES", .rank = 2},
             day(token.expires_s));
  report.for_programs("revoked", or_null(token.revoked_s));
  report.add("last_used", or_null(token.last_used_s), Column{.head = "LAST USED", .rank = 4},
             day(token.last_used_s));
  report.add("last_from", token.last_from.empty() ? Json(nullptr) : Json(token.last_from),
             Column{.head = "FROM", .rank = 5}, terminal::shown(token.last_from));
  report.add("name", token.name, Column{.head = "NAME"}, terminal::shown(token.name));
  report.for_programs("jobs_max", limit(token.jobs_max));
  report.for_programs("cores_max", limit(token.cores_max));
  return report;
}

/// A new file that only its owner can read. An existing file is never replaced.
class SecretFile {
 public:
  explicit SecretFile(const std::string& path)
      : path_(path),
        file_(::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC | O_NOFOLLOW, 0600)) {
    if (file_) return;
    throw base::Error(
        errno == EEXIST ? base::ExitCode::conflict : base::ExitCode::environment,
        fmt::format("{}: {}", terminal::shown(path), std::system_category().message(errno)));
  }
  void write(const std::string& text) const {
    if (::write(file_.get(), text.data(), text.size()) != static_cast<ssize_t>(text.size()) ||
        ::fsync(file_.get()) != 0) {
      throw base::Error(
          fmt::format("{}: {}", terminal::shown(path_), std::system_category().message(errno)));
    }
  }
  void remove() const { static_cast<void>(::unlink(path_.c_str())); }

 private:
  std::string path_;
  base::Descriptor file_;
};

}  // namespace

double validity_s_of(const std::string& text) {
  if (text == "never") return 0;
  std::optional<double> seconds;
  if (text.ends_with('d')) {
    const auto days = config::duration_s_of(text.substr(0, text.size() - 1) + "s");
    if (days) seconds = *days * k_day_s;
  } else {
    seconds = config::duration_s_of(text);
  }
  if (!seconds || *seconds > rpc::k_token_s_max) {
    terminal::refuse_usage(fmt::format(
        "--expires: expected a time of at most ten years, such as 90d or 12h, or never; found '{}'",
        terminal::shown(text)));
  }
  return *seconds;
}

int create_token(const std::string& called, const TokenCreateOptions& options) {
  rpc::TokenAsk ask{.name = options.name,
                    .valid_s = validity_s_of(options.expires),
                    .jobs_max = options.jobs_max,
                    .cores_max = options.cores_max};
  for (const std::string& name : options.scopes) {
    const auto scope = rpc::scope_of(name);
    if (!scope) {
      terminal::refuse_usage(
          fmt::format("--scope: unknown scope '{}'; expected read, submit, manage or operate",
                      terminal::shown(name)));
    }
    ask.scopes.add(*scope);
  }
  if (options.user) {
    ask.for_user = terminal::user_of(*options.user);
    if (!ask.for_user)
      terminal::refuse_usage(
          fmt::format("--user: no user '{}' on this machine", terminal::shown(*options.user)));
  }
  ask.token = access::text_of(access::draw_token());
  std::optional<SecretFile> file;
  if (!options.output.empty()) {
    // Create the file before the token, because a token without a file is useless.
    file.emplace(options.output);
    file->write(ask.token + "\n");
  }
  try {
    return service_client::with_service(called, [&](rpc::Client& client) {
      const rpc::TokenView token = client.create_token(ask);
      if (options.json) {
        Json json = report_of(token).as_json();
        if (!file) json["token"] = ask.token;
        fmt::print("{}\n", indented(json));
        return terminal::k_ok;
      }
      terminal::complain(
          fmt::format("token {} of {}, {}; scopes: {}. The token can't be shown again. It {}.",
                      token.id, terminal::name_of_user(token.user),
                      token.expires_s > 0 ? fmt::format("valid until {}", day_of(token.expires_s))
                                          : std::string("valid until it is revoked"),
                      fmt::join(names_of(token.scopes), ", "),
                      file ? "is in " + options.output : std::string("follows")));
      if (!file) fmt::print("{}\n", ask.token);
      return terminal::k_ok;
    });
  } catch (...) {
    if (file) file->remove();
    throw;
  }
}

int list_tokens(const std::string& called, bool all, bool json) {
  return service_client::with_service(called, [&](rpc::Client& client) {
    std::vector<rpc::TokenView> tokens = client.tokens();
    if (!all) {
      std::erase_if(tokens,
                    [](const rpc::TokenView& token) { return state_of_token(token) != "valid"; });
    }
    const std::vector<report::Report> reports = report::reports_of(tokens, report_of);
    if (json) {
      fmt::print("{}\n", indented(report::list_of(reports)));
      return terminal::k_ok;
    }
    if (tokens.empty()) {
      fmt::print("no tokens\n");
      return terminal::k_ok;
    }
    fmt::print("{}", to_text(report::table_of(reports), terminal::width_of(stdout)));
    return terminal::k_ok;
  });
}

int revoke_tokens(const std::string& called, const TokenRevokeOptions& options) {
  for (const std::string& id : options.ids) {
    if (!access::is_token_id(id)) {
      terminal::refuse_usage(
          fmt::format("'{}' is not a token id; to list the ids, run `sleight token list`",
                      terminal::shown(id.substr(0, 20))));
    }
  }
  return service_client::with_service(called, [&](rpc::Client& client) {
    Json list = Json::array();
    auto code = base::ExitCode::ok;
    for (const std::string& id : options.ids) {
      try {
        const rpc::TokenView token = client.revoke_token(id);
        list.push_back(report_of(token).as_json());
        if (!options.json) {
          fmt::print("token {} ({}) is revoked; its sessions end\n", terminal::shown(token.id),
                     terminal::shown(token.name));
        }
      } catch (const rpc::RefusedError& refused) {
        // Revoke the other tokens anyway.
        terminal::complain(
            fmt::format("sleight: {}: {}", id, service_client::words_of(refused.refusal())));
        code = service_client::exit_code_of(refused.refusal().kind);
      }
    }
    if (options.json) fmt::print("{}\n", indented(list));
    return static_cast<int>(code);
  });
}

}  // namespace sleight::cli
