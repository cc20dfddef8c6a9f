// `sleight-bench`: every benchmark of the project.
#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "common/base/version.h"
#include "tests/bench/harness.h"

namespace {

/// Returns a regular expression for names such as "store" or "ball_2d/chain".
std::string filter_of(const std::vector<std::string>& names) {
  std::string filter;
  for (const std::string& name : names)
    filter += (filter.empty() ? "^" : "|^") + name;
  return filter.empty() ? "." : filter;
}

/// All benchmarks except scenes of many bodies, because such scenes take seconds to minutes.
constexpr const char* k_all_but_large =
    "-^(box/.*/(512|4096)|hourglass/.*/([4-9]0|100|1000)|wall/|broad_phase/.*/10648)";

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Runs Sleight's benchmarks. Each checks a hash of its results."};
  app.name("sleight-bench");
  app.set_version_flag("--version", "sleight-bench " + std::string(sleight::base::version()));
  std::vector<std::string> names;
  bool json = false;
  bool list = false;
  bool check = false;
  bool small = false;
  std::size_t repetitions = 1;
  app.add_option("names", names, "Beginnings of benchmark names; all if none");
  app.add_flag("--json", json, "Results as JSON on stdout");
  app.add_flag("--list", list, "Only list the names");
  app.add_flag("--check", check, "Only check the result hashes, with little timing");
  app.add_flag("--small", small, "Leave out scenes of many bodies, which take minutes")
      ->excludes("names");
  app.add_option("--repetitions", repetitions, "Repeat each, with mean and median")
      ->check(CLI::Range(1, 1000));
  app.footer(
      "Exit codes: 0 all hashes right; 1 a wrong hash.\n\nExamples:\n"
      "  sleight-bench store\n  sleight-bench ball_2d --repetitions 5\n  sleight-bench --json");
  CLI11_PARSE(app, argc, argv);

  std::vector<std::string> arguments = {
      argv[0], "--benchmark_filter=" + (small ? k_all_but_large : filter_of(names)),
      fmt::format("--benchmark_repetitions={}", repetitions)};
  if (json) arguments.emplace_back("--benchmark_format=json");
  if (list) arguments.emplace_back("--benchmark_list_tests=true");
  if (check) arguments.emplace_back("--benchmark_min_time=0.001");
  std::vector<char*> pointers;
  for (std::string& argument : arguments)
    pointers.push_back(argument.data());
  int count = static_cast<int>(pointers.size());
  benchmark::Initialize(&count, pointers.data());
  benchmark::AddCustomContext("version", std::string(sleight::base::version()));
  benchmark::RunSpecifiedBenchmarks();
  return sleight::bench::any_wrong() ? 1 : 0;
}
