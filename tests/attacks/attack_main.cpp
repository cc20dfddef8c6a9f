// `sleight-attack` attacks a running service on its socket and over TLS, and reports whether the
// service survived. tests/programs/test_attacks.py and deploy/soak run the program. It isn't
// installed.
//
// Exits with 0 if all kinds of attack occurred and reached the server, honest clients were always
// answered, and nothing else went wrong. Otherwise exits with 1.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <csignal>
#include <cstdio>
#include <string>

#include "common/base/error.h"
#include "common/base/file_system.h"
#include "tests/attacks/campaign.h"

namespace sleight::attack {
namespace {

constexpr std::size_t k_file_bytes_max = 1U << 20U;

struct Options {
  std::string socket{};
  std::string address{};
  std::string token_file{};
  std::string certificate{};
  Campaign campaign{};
};

void tell(const Options& options, const Progress& progress) {
  const double rate = static_cast<double>(progress.attacks) / progress.seconds;
  const double left = options.campaign.count > progress.attacks
                          ? static_cast<double>(options.campaign.count - progress.attacks)
                          : 0;
  fmt::print("{} of {} attacks, {:.0f} a second, {:.0f} s left\n", progress.attacks,
             options.campaign.count, rate, rate > 0 ? left / rate : 0);
  std::fflush(stdout);
}

/// Prints the others.
bool judge(const Outcome& outcome) {
  bool is_good = true;
  for (const Count& count : outcome.counts) {
    const char* words = "";
    if (count.attacks == 0) words = "  NEVER OCCURRED";
    if (count.attacks > 0 && count.reached == 0) words = "  NEVER REACHED THE SERVER";
    if (words[0] != '\0') is_good = false;
    fmt::print("{:>10} {:>10} {:>8}  {}{}\n", count.attacks, count.reached, count.turned_away,
               count.name, words);
  }
  return is_good;
}

int run(const Options& options) {
  Target target;
  target.socket = options.socket;
  const auto address = access::server_address_of(options.address);
  if (!address || address->host != "127.0.0.1")
    throw base::Error(base::ExitCode::usage, "--address: expected 127.0.0.1:PORT");
  target.address = *address;
  target.token = base::read_text_file(options.token_file, k_file_bytes_max);
  while (!target.token.empty() && target.token.back() == '\n')
    target.token.pop_back();
  Campaign campaign = options.campaign;
  campaign.certificate = base::read_text_file(options.certificate, k_file_bytes_max);
  fmt::print("seed {}\n", campaign.seed);
  const Outcome outcome =
      run_campaign(target, campaign, [&](const Progress& progress) { tell(options, progress); });
  bool is_good = true;
  if (!campaign.episode) {
    fmt::print("{:>10} {:>10} {:>8}\n", "attacks", "answered", "no room");
    is_good = judge(outcome);
    if (outcome.honest_calls == 0) is_good = false;
    fmt::print("{} honest calls, the longest visit {:.2f} s\n", outcome.honest_calls,
               outcome.longest_honest_s);
  }
  fmt::print("{} attacks in {:.1f} s: {:.0f} a second\n", outcome.attacks, outcome.seconds,
             static_cast<double>(outcome.attacks) / outcome.seconds);
  if (outcome.trouble) {
    fmt::print("FAILED: {}\nto see it again: --seed {} --episode N\n", *outcome.trouble,
               campaign.seed);
  }
  return is_good && !outcome.trouble ? 0 : 1;
}

int main_of(int argc, char** argv) {
  ::signal(SIGPIPE, SIG_IGN);
  CLI::App app("Attacks a service of Sleight that runs on this machine.");
  Options options;
  app.add_option("--socket", options.socket, "The service's")->required();
  app.add_option("--address", options.address, "Where it listens over TLS")->required();
  app.add_option("--token-file", options.token_file, "A valid token")->required();
  app.add_option("--certificate", options.certificate, "The service's, in PEM")->required();
  app.add_option("--count", options.campaign.count, "Of attacks")->required();
  app.add_option("--seed", options.campaign.seed)->capture_default_str();
  app.add_option("--threads", options.campaign.threads)
      ->check(CLI::Range(1, 64))
      ->capture_default_str();
  app.add_option("--episode", options.campaign.episode, "This one alone");
  try {
    app.parse(argc, argv);
    return run(options);
  } catch (const CLI::ParseError& error) {
    return app.exit(error);
  } catch (const base::Error& error) {
    fmt::print(stderr, "sleight-attack: {}\n", error.what());
    return static_cast<int>(error.exit_code());
  }
}

}  // namespace
}  // namespace sleight::attack

int main(int argc, char** argv) {
  return sleight::attack::main_of(argc, argv);
}
