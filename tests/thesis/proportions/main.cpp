// Tests whether sampling methods agree on a word. Compares draws by islands, by tempering from
// searches, and by long plain chains. Also compares these draws with solutions of requests without
// a sampler, which differ in their seeds. Prints a table, and exits with 1 if a p-value is below
// --p-min. The option --tours shows how far chains of islands have moved from their starts by each
// scan. The option --throws counts satisfying throws.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <ctime>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "common/base/version.h"
#include "tests/statistical/support/chi_square.h"
#include "tests/statistical/support/rank_tests.h"
#include "tests/thesis/proportions/draws.h"

namespace {

using sleight::thesis::Counted;
using sleight::thesis::is_count;
using sleight::thesis::k_quantities;
using sleight::thesis::Series;
using sleight::thesis::Values;

struct Arguments {
  std::string word = "HI";
  double effort = 1;
  std::uint32_t first_seed = 1;
  std::uint32_t seeds = 400;
  unsigned threads = 2;
  double p_min = 1e-4;
  double limit_s = std::numeric_limits<double>::infinity();
  std::uint64_t throws = 0;
  std::uint32_t tours = 0;
  bool relaxed = false;
  std::uint32_t scans = 16;
  std::vector<std::string> keys{};
};

/// Effectively independent draws of one quantity. The mean is over all draws, before thinning.
struct Sample {
  std::string way;
  std::vector<double> thinned;
  double mean = 0;
  double error = 0;
};

Sample independent(const std::string& way, const std::vector<Values>& draws, std::size_t quantity) {
  Sample sample{.way = way, .thinned = {}};
  for (const Values& values : draws)
    sample.thinned.push_back(values.at(quantity));
  const auto mean = sleight::statistical::mean_of_independent(sample.thinned);
  sample.mean = mean.mean;
  sample.error = mean.standard_error;
  return sample;
}

/// Averages each seed's counted solutions, and then over seeds. Averages are less noisy than one
/// solution per seed, but aren't draws from the distribution.
Sample mean_of_seeds(const std::vector<Counted>& counted, std::size_t quantity) {
  std::vector<double> means;
  for (const Counted& each : counted) {
    if (each.solutions.empty()) continue;
    double sum = 0;
    for (const Values& values : each.solutions)
      sum += values.at(quantity);
    means.push_back(sum / static_cast<double>(each.solutions.size()));
  }
  const auto mean = sleight::statistical::mean_of_independent(means);
  return {.way = "default, all counted",
          .thinned = {},
          .mean = mean.mean,
          .error = mean.standard_error};
}

/// Returns evenly spaced draws of each chain. The number of draws is the quantity's effective
/// sample size.
Sample thinned(const std::string& way, const Series& series, std::size_t quantity) {
  Sample sample{.way = way, .thinned = {}};
  std::vector<std::vector<double>> chains;
  for (const auto& chain : series) {
    if (chain.size() < 10) continue;
    std::vector<double>& values = chains.emplace_back();
    for (const Values& draw : chain)
      values.push_back(draw.at(quantity));
    const double size = std::clamp(sleight::statistical::effective_sample_size(values), 1.0,
                                   static_cast<double>(values.size()));
    const auto count = static_cast<std::size_t>(size);
    for (std::size_t i = 0; i < count; ++i)
      sample.thinned.push_back(values[(2 * i + 1) * values.size() / (2 * count)]);
  }
  if (chains.empty()) return sample;
  const auto mean = sleight::statistical::mean_of_chains(chains);
  sample.mean = mean.mean;
  sample.error = mean.standard_error;
  return sample;
}

double p_value(const Sample& a, const Sample& b, std::size_t quantity) {
  if (a.thinned.empty() || b.thinned.empty()) return 1;
  if (!is_count(quantity)) return sleight::statistical::kolmogorov_smirnov_p(a.thinned, b.thinned);
  constexpr std::size_t k_cells = 100;
  std::vector<double> counts_a(k_cells, 0);
  std::vector<double> counts_b(k_cells, 0);
  for (const double value : a.thinned)
    ++counts_a.at(static_cast<std::size_t>(value));
  for (const double value : b.thinned)
    ++counts_b.at(static_cast<std::size_t>(value));
  // Merge all cells that have fewer than ten draws.
  double rare_a = 0;
  double rare_b = 0;
  std::vector<double> a_of;
  std::vector<double> b_of;
  for (std::size_t cell = 0; cell < k_cells; ++cell) {
    const bool is_rare = counts_a[cell] + counts_b[cell] < 10;
    (is_rare ? rare_a : a_of.emplace_back()) += counts_a[cell];
    (is_rare ? rare_b : b_of.emplace_back()) += counts_b[cell];
  }
  a_of.push_back(rare_a);
  b_of.push_back(rare_b);
  // If only one cell has draws, there is nothing to compare.
  const auto is_used = [&](std::size_t cell) { return a_of[cell] + b_of[cell] > 0; };
  std::size_t used = 0;
  for (std::size_t cell = 0; cell < a_of.size(); ++cell)
    used += is_used(cell) ? 1 : 0;
  if (used < 2) return 1;
  return sleight::statistical::two_sample_p(a_of, b_of);
}

std::string request_of(const Arguments& arguments, const std::string& sampler,
                       const std::string& stop) {
  return fmt::format("[world]\nname = \"spelling\"\nword = \"{}\"\n{}[stop]\n{}\n", arguments.word,
                     sampler, stop);
}

/// Returns a sampler that has the proposal shares of requests without a sampler. By default, the
/// sampler also has the constraint of these requests. Lambda changes how many draws satisfy the
/// constraint, but not the proportions among these draws.
std::string sampler_of(const Arguments& arguments, const std::string& keys,
                       std::optional<double> log_lambda) {
  const auto balls =
      static_cast<double>(sleight::thesis::balls_of(request_of(arguments, "", "scans = 100")));
  return fmt::format(
      "[constraint]\nlog_lambda = {}\n[sampler]\nchange_all = 0.01\nchange_vertices = 0.25\n"
      "change_ball = 0.14\ndisable_balls = 0.02\nenable_balls = 0.02\naim_ball = 0.28\n"
      "scatter_ball = 0.28\nvertex_redraw = 1.0\nball_move_sd_mm = 2.0\n{}",
      log_lambda.value_or(std::round(6 + std::log(balls))), keys);
}

struct Way {
  std::string name;
  std::function<Series()> draw;
  Series series{};
};

std::vector<Way> all_ways(const Arguments& arguments) {
  const auto scans = [&](double of_full) {
    return std::max<std::uint64_t>(40, static_cast<std::uint64_t>(of_full * arguments.effort));
  };
  const auto way = [&](const std::string& name, const std::string& keys, std::uint64_t count,
                       std::uint64_t burn_in, std::optional<double> log_lambda = {}) {
    const std::string text = request_of(arguments, sampler_of(arguments, keys, log_lambda),
                                        fmt::format("scans = {}", count));
    return Way{.name = name, .draw = [text, burn_in] {
                 return sleight::thesis::satisfying_draws(text, burn_in);
               }};
  };
  std::vector<Way> ways;
  // Tempering starts first, because it is the slowest. Plain chains have a weaker constraint than
  // the others, so that balls enter and leave the bins.
  ways.push_back(way("tempering",
                     "method = \"parallel_tempering\"\nstart = \"search\"\nchains = 2\n"
                     "iterations_per_scan = 40\nround_scans = 50\n",
                     scans(6350), scans(6350) / 2));
  ways.push_back(way("plain chains",
                     "method = \"metropolis_hastings\"\nchains = 16\niterations_per_scan = 100\n",
                     scans(3000), scans(3000) / 10, 6));
  ways.push_back(way("islands",
                     "method = \"sequential\"\nparticles = 32\nchains = 4\n"
                     "iterations_per_scan = 64\nround_scans = 10\n",
                     scans(600), 20));
  return ways;
}

/// After the time limit, no further optional task starts.
void run_all(const std::vector<std::function<void()>>& tasks, std::size_t can_be_left_out_from,
             const Arguments& arguments) {
  const auto begin = std::chrono::steady_clock::now();
  const auto seconds = [&] {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  };
  const unsigned threads = std::max(1U, arguments.threads);
  std::atomic<std::size_t> next = 0;
  std::atomic<std::size_t> done = 0;
  std::vector<std::jthread> workers;
  for (unsigned thread = 0; thread < threads; ++thread) {
    workers.emplace_back([&] {
      for (std::size_t i = next++; i < tasks.size(); i = next++) {
        if (i >= can_be_left_out_from && seconds() > arguments.limit_s) return;
        tasks[i]();
        const std::size_t count = ++done;
        if (i < can_be_left_out_from || count % 20 == 0)
          fmt::print(stderr, "{} of {} runs after {:.0f} s\n", count, tasks.size(), seconds());
      }
    });
  }
}

/// Shows how far chains have moved from their starts. For each scan, prints the mean number of
/// helped balls over states that satisfy the constraint.
void show_burn_in(const Arguments& arguments) {
  std::string keys = "method = \"sequential\"\nburn_in_rounds = 1\nround_scans = 1\n";
  for (const std::string& key : arguments.keys)
    keys += key + "\n";
  const unsigned threads = std::clamp(arguments.threads, 1U, arguments.tours);
  std::vector<std::vector<std::vector<double>>> helped(threads);  // by thread, by scan
  std::vector<std::function<void()>> tasks;
  for (unsigned thread = 0; thread < threads; ++thread) {
    tasks.emplace_back([&, thread] {
      const std::string text =
          request_of(arguments,
                     sampler_of(arguments,
                                fmt::format("{}chains = {}\nseed = {}\n", keys,
                                            (arguments.tours + thread) / threads,
                                            arguments.first_seed + thread),
                                {}),
                     fmt::format("scans = {}", arguments.scans));
      helped[thread] = sleight::thesis::helped_by_scan(text);
    });
  }
  const auto begin = std::clock();
  run_all(tasks, tasks.size(), arguments);
  const double seconds = static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
  fmt::print("{}: {} tours of {} scans, {:.3f} s of processor a scan\n", arguments.word,
             arguments.tours, arguments.scans, seconds / arguments.tours / arguments.scans);
  for (std::uint32_t scan = 0; scan < arguments.scans; ++scan) {
    std::vector<double> values;
    for (const auto& of_thread : helped)
      if (scan < of_thread.size())
        values.insert(values.end(), of_thread[scan].begin(), of_thread[scan].end());
    const auto mean = sleight::statistical::mean_of_independent(values);
    fmt::print("{:4} {:8.3f} +- {:.3f}  {:.0f}% satisfied\n", scan, mean.mean, mean.standard_error,
               100.0 * static_cast<double>(values.size()) / arguments.tours);
  }
}

/// Prints how takes differ from draws of long chains, in standard deviations of a draw.
void show_relaxed(const Arguments& arguments) {
  const auto balls =
      static_cast<double>(sleight::thesis::balls_of(request_of(arguments, "", "scans = 100")));
  const auto scans = static_cast<std::uint64_t>(1500 * arguments.effort);
  // Helped balls appear fastest if proposals move drops by large distances.
  const std::string chains = request_of(
      arguments,
      fmt::format("[constraint]\nlog_lambda = {}\n[sampler]\nmethod = \"metropolis_hastings\"\n"
                  "start = \"search\"\nchains = 8\nround_scans = 1000000\n"
                  "iterations_per_scan = 100\nchange_all = 0\nchange_vertices = 0.1\n"
                  "change_ball = 0.6\ndisable_balls = 0\nenable_balls = 0\naim_ball = 0.15\n"
                  "scatter_ball = 0.15\nvertex_redraw = 1.0\nball_move_sd_mm = 26\n",
                  std::round(5 + std::log(balls))),
      fmt::format("scans = {}", scans));
  std::vector<Series> of_chains(2);
  std::vector<std::vector<Values>> of_seeds(arguments.seeds);
  std::vector<std::function<void()>> tasks;
  for (std::size_t half = 0; half < of_chains.size(); ++half) {
    std::string text = chains;
    text.replace(text.find("chains = 8"), 10, fmt::format("seed = {}\nchains = 8", 900 + half));
    tasks.emplace_back([&of_chains, half, text, scans] {
      of_chains[half] = sleight::thesis::satisfying_draws(text, scans / 3);
    });
  }
  for (std::uint32_t nth = 0; nth < arguments.seeds; ++nth) {
    std::string keys = fmt::format("[sampler]\nseed = {}\n", arguments.first_seed + nth);
    tasks.emplace_back([&arguments, &takes = of_seeds[nth], keys] {
      takes = sleight::thesis::takes_of(request_of(arguments, keys, "takes = 1"));
    });
  }
  run_all(tasks, of_chains.size(), arguments);
  Series all = of_chains[0];
  all.insert(all.end(), of_chains[1].begin(), of_chains[1].end());
  std::vector<Values> takes;
  for (const auto& of_seed : of_seeds)
    takes.insert(takes.end(), of_seed.begin(), of_seed.end());
  fmt::print("{}: takes of {} seeds beside {} chains of {} scans\n", arguments.word, takes.size(),
             all.size(), scans);
  for (std::size_t quantity = 0; quantity < k_quantities.size(); ++quantity) {
    const Sample of_long = thinned("long chains", all, quantity);
    const Sample relaxed = independent("takes", takes, quantity);
    double squares = 0;
    for (const double value : of_long.thinned)
      squares += (value - of_long.mean) * (value - of_long.mean);
    const double sd = std::sqrt(squares / static_cast<double>(of_long.thinned.size()));
    fmt::print(
        "{:18} chains {:10.5g} +- {:<8.2g} takes {:10.5g} +- {:<8.2g} apart {:+.2f} +- "
        "{:.2f} sd, {} draws, p {:.2g}\n",
        k_quantities.at(quantity), of_long.mean, of_long.error, relaxed.mean, relaxed.error,
        (relaxed.mean - of_long.mean) / sd, std::hypot(of_long.error, relaxed.error) / sd,
        of_long.thinned.size(), p_value(of_long, relaxed, quantity));
  }
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Whether ways of sampling a word agree, and what counts as a solution with them"};
  app.set_version_flag("--version", "sleight-proportions " + std::string(sleight::base::version()));
  Arguments arguments;
  app.add_option("--word", arguments.word)->capture_default_str();
  app.add_option("--effort", arguments.effort,
                 "Of the three ways; 1 gives each some hundreds of draws, 0 leaves them out")
      ->capture_default_str();
  app.add_option("--seeds", arguments.seeds, "Of requests without a sampler")
      ->capture_default_str();
  app.add_option("--first-seed", arguments.first_seed)->capture_default_str();
  app.add_option("--threads", arguments.threads)->capture_default_str();
  app.add_option("--limit", arguments.limit_s, "Seconds; no seed begins after them");
  app.add_option("--p-min", arguments.p_min, "Below it the program fails")->capture_default_str();
  app.add_option("--throws", arguments.throws,
                 "Nothing but this: how many of so many blind throws spell it");
  app.add_option("--tours", arguments.tours,
                 "Nothing but this: helped balls by scan of so many chains of islands");
  app.add_option("--scans", arguments.scans, "Of each tour")->capture_default_str();
  app.add_option("--keys", arguments.keys, "Of the tours' [sampler], \"particles = 128\"");
  app.add_flag("--relaxed", arguments.relaxed,
               "Nothing but this: takes of so many seeds beside long chains");
  app.footer(
      "Examples:\n  sleight-proportions\n  sleight-proportions --word I --effort 0.1 --seeds 20");
  CLI11_PARSE(app, argc, argv);

  if (arguments.throws > 0) {
    const auto text = request_of(arguments, "", "scans = 100");
    fmt::print("{} of {} throws spell {}\n",
               sleight::thesis::satisfying_throws(text, arguments.throws), arguments.throws,
               arguments.word);
    return 0;
  }
  if (arguments.tours > 0) {
    show_burn_in(arguments);
    return 0;
  }
  if (arguments.relaxed) {
    show_relaxed(arguments);
    return 0;
  }
  std::vector<Way> ways = arguments.effort > 0 ? all_ways(arguments) : std::vector<Way>{};
  std::vector<Counted> counted(arguments.seeds);
  std::vector<std::function<void()>> tasks;
  for (Way& way : ways)
    tasks.emplace_back([&way] { way.series = way.draw(); });
  for (std::uint32_t nth = 0; nth < arguments.seeds; ++nth) {
    const std::uint32_t seed = arguments.first_seed + nth;
    tasks.emplace_back([&arguments, &result = counted[nth], seed] {
      result = sleight::thesis::counted_solutions(
          request_of(arguments, fmt::format("[sampler]\nseed = {}\n", seed),
                     "independent_solutions = 5\nfound = 1"));
    });
  }
  run_all(tasks, ways.size(), arguments);

  // Use one solution per seed, because solutions of the same seed depend on each other.
  std::vector<Values> first_of_seed;
  std::vector<Values> any_of_seed;
  std::vector<Values> last_of_seed;
  const auto ran = std::ranges::count_if(counted, &Counted::has_run);
  for (const Counted& each : counted) {
    if (!each.solutions.empty()) first_of_seed.push_back(each.solutions.front());
    if (!each.solutions.empty()) last_of_seed.push_back(each.solutions.back());
    any_of_seed.insert(any_of_seed.end(), each.any_scan.begin(), each.any_scan.end());
  }
  fmt::print("{}: {} seeds without a sampler, {} with solutions\n\n", arguments.word, ran,
             first_of_seed.size());
  double least = 1;
  for (std::size_t quantity = 0; quantity < k_quantities.size(); ++quantity) {
    std::vector<Sample> samples;
    for (const Way& way : ways)
      samples.push_back(thinned(way.name, way.series, quantity));
    samples.push_back(independent("default, first counted", first_of_seed, quantity));
    samples.push_back(independent("default, last counted", last_of_seed, quantity));
    samples.push_back(independent("default, any scan", any_of_seed, quantity));
    samples.push_back(mean_of_seeds(counted, quantity));
    fmt::print("{}\n", k_quantities.at(quantity));
    for (std::size_t i = 0; i < samples.size(); ++i) {
      const std::size_t draws = samples[i].thinned.size();
      fmt::print("  {:22} {:10.5g} +- {:<8.2g} {}", samples[i].way, samples[i].mean,
                 samples[i].error,
                 draws > 0 ? fmt::format("{:5} draws", draws) : "      of seeds' means");
      for (std::size_t j = 0; j < std::min<std::size_t>(i, ways.size()); ++j) {
        const double p = p_value(samples[i], samples[j], quantity);
        least = std::min(least, p);
        fmt::print("  p {:.2g}", p);
      }
      fmt::print("\n");
    }
  }
  fmt::print("\nleast p-value: {:.2g}\n", least);
  return least < arguments.p_min ? 1 : 0;
}
