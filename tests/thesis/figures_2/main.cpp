// `sleight-figures-2`: reproduces figures 2.8 to 2.13 of the thesis. The program makes figures 2.8
// to 2.12 twice: with the kernel that A.2.2 prints, and with the correct kernel.
#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <string>
#include <thread>
#include <vector>

#include "clients/plot/save.h"
#include "common/base/clock.h"
#include "common/base/error.h"
#include "common/base/version.h"
#include "tests/thesis/figures_2/chain.h"
#include "tests/thesis/figures_2/dice.h"
#include "tests/thesis/figures_2/figures.h"
#include "tests/thesis/figures_2/statistics.h"
#include "worker/worlds/spelling/pattern.h"

namespace {

using namespace sleight::thesis;
namespace plot = sleight::plot;
namespace spelling = sleight::worlds::spelling;
using spelling::Kernel;

struct Arguments {
  std::string out = "docs/figures";
  std::vector<std::string> only;
  std::uint64_t iterations = 0;
  std::uint64_t seed = 2000;
  unsigned threads = 2;
  bool quick = false;
  std::vector<std::string> notes = {};  ///< of each picture (clients/plot/notes.h)
};

struct Plan {
  std::string figures;  ///< "2.8 2.9"
  std::string what;
  spelling::Parameters parameters;
  ChainOptions options = {};
  Kernel kernel = Kernel::correct;

  bool draws(const std::string& figure) const {
    return (" " + figures + " ").find(" " + figure + " ") != std::string::npos;
  }
};

struct Result {
  Chain chain;
  Statistics statistics;
  std::vector<Order> orders;  ///< of the chain's best states
  double elapsed_s = 0;
};

const char* name_of(Kernel kernel) {
  return kernel == Kernel::thesis ? "thesis" : "correct";
}

std::vector<Plan> plans_of(const Arguments& arguments) {
  const auto of = [](double log_lambda, const spelling::Pattern& pattern) {
    spelling::Parameters parameters;
    parameters.pattern = pattern;
    parameters.constraint.log_lambda = log_lambda;
    return parameters;
  };
  // The numbers of iterations are from the thesis. The thesis has no number for figure 2.12, so
  // that figure uses the number of requests/acm.toml.
  const spelling::Pattern hi = spelling::hi();
  const spelling::Pattern acm = spelling::pattern_of_word("ACM", spelling::Font::rows_5).value();
  const std::array wanted{
      Plan{.figures = "2.8 2.9", .what = "HI, lambda = e^5", .parameters = of(5, hi)},
      Plan{.figures = "2.10", .what = "HI, lambda = e^4", .parameters = of(4, hi)},
      Plan{.figures = "2.11", .what = "HI, lambda = e^6", .parameters = of(6, hi)},
      Plan{.figures = "2.12",
           .what = "ACM, lambda = e^7.25",
           .parameters = of(7.25, acm),
           .options = {.iterations = 100'000}}};
  std::vector<Plan> plans;
  for (Plan plan : wanted) {
    const bool asked =
        arguments.only.empty() ||
        std::ranges::any_of(arguments.only, [&](const auto& figure) { return plan.draws(figure); });
    if (!asked) continue;
    if (arguments.quick) {
      plan.parameters.pattern = spelling::pattern_of_rows(".#.\n#..").value();
      plan.options.iterations = 100;
    }
    if (arguments.iterations > 0) plan.options.iterations = arguments.iterations;
    plan.options.seed = arguments.seed;
    for (const Kernel kernel : {Kernel::thesis, Kernel::correct}) {
      plan.kernel = kernel;
      plan.parameters.proposal.kernel = kernel;
      plans.push_back(plan);
    }
  }
  return plans;
}

/// Prints rate and remaining time to stderr. On a terminal, updates one line; otherwise, prints a
/// new line now and then.
class ProgressLine {
 public:
  explicit ProgressLine(const std::vector<Plan>& plans) : plans_(plans) {}

  /// `done`: iterations of each chain so far.
  void show(const std::vector<std::atomic<std::uint64_t>>& done) {
    const double now_s = clock_.now_s() - begin_s_;
    if (now_s < next_s_) return;
    next_s_ = now_s + (terminal_ ? 0.5 : 15);
    // Weight iterations by the number of balls, which determines the cost.
    std::uint64_t iterations = 0;
    std::uint64_t all_iterations = 0;
    double work = 0;
    double all_work = 0;
    for (std::size_t i = 0; i < plans_.size(); ++i) {
      const std::uint64_t each = done[i];
      const double balls = plans_[i].parameters.pattern.count();
      iterations += each;
      all_iterations += plans_[i].options.iterations;
      work += balls * static_cast<double>(each);
      all_work += balls * static_cast<double>(plans_[i].options.iterations);
    }
    if (iterations == 0) return;
    fmt::print(stderr, "{}{} of {} iterations  {:.0f}/s  {:.0f} s left{}", terminal_ ? "\r" : "",
               iterations, all_iterations, static_cast<double>(iterations) / now_s,
               now_s * (all_work / work - 1), terminal_ ? "   " : "\n");
  }
  void finish() const {
    if (terminal_) fmt::print(stderr, "\n");
  }

 private:
  sleight::base::SteadyClock clock_;
  const std::vector<Plan>& plans_;
  bool terminal_ = isatty(STDERR_FILENO) == 1;
  double begin_s_ = clock_.now_s();
  double next_s_ = 1;
};

/// Runs each chain in its own thread. At most `threads` chains run at a time.
std::vector<Result> run_all(const std::vector<Plan>& plans, unsigned threads) {
  std::vector<Result> results(plans.size());
  std::vector<std::exception_ptr> failures(plans.size());
  std::vector<std::atomic<std::uint64_t>> done(plans.size());
  std::atomic<std::size_t> next = 0;
  std::atomic<std::size_t> ended = 0;
  const auto work = [&] {
    const sleight::base::SteadyClock clock;
    for (std::size_t i = next++; i < plans.size(); i = next++) {
      const double begin_s = clock.now_s();
      try {
        results[i].chain = run_chain(plans[i].parameters, plans[i].options, done[i]);
        results[i].statistics = statistics_of(results[i].chain);
        results[i].orders = orders_of(plans[i].parameters, results[i].chain.best);
      } catch (...) {
        failures[i] = std::current_exception();
      }
      results[i].elapsed_s = clock.now_s() - begin_s;
      ++ended;
    }
  };
  ProgressLine progress(plans);
  {
    std::vector<std::jthread> workers;
    for (unsigned thread = 0; thread < threads; ++thread)
      workers.emplace_back(work);
    while (ended < plans.size()) {
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
      progress.show(done);
    }
  }
  progress.finish();
  for (const std::exception_ptr& failure : failures) {
    if (failure) std::rethrow_exception(failure);
  }
  return results;
}

void draw(const Plan& plan, const Result& result, const Arguments& arguments) {
  const plot::Notes notes = plot::notes_of(arguments.notes);
  const std::string kernel =
      plan.kernel == Kernel::thesis ? "kernel as A.2.2 prints it (biased)" : "correct kernel";
  const std::string title = fmt::format("{}: {}", plan.what, kernel);
  for (const char* figure : {"2.8", "2.9", "2.10", "2.11", "2.12"}) {
    const bool asked = arguments.only.empty() || std::ranges::count(arguments.only, figure) > 0;
    if (!asked || !plan.draws(figure)) continue;
    std::string name = figure;
    std::ranges::replace(name, '.', '_');
    const std::string path =
        fmt::format("{}/figure_{}_{}.svg", arguments.out, name, name_of(plan.kernel));
    if (std::string_view(figure) == "2.9") {
      plot::save(log_p_figure(title, result.chain, result.statistics), path, {.notes = notes});
    } else {
      plot::save(filled_figure(title, result.chain), path, {.notes = notes});
    }
  }
}

void print_row(const std::string& name, const std::vector<Result>& results, const auto& cell) {
  fmt::print("| {} |", name);
  for (const Result& result : results)
    fmt::print(" {} |", cell(result));
  fmt::print("\n");
}

void print_table(const std::vector<Plan>& plans, const std::vector<Result>& results,
                 std::uint64_t seed) {
  fmt::print("seed {}\n\n| |", seed);
  for (const Plan& plan : plans)
    fmt::print(" {}, {} |", plan.what, name_of(plan.kernel));
  fmt::print("\n|---|");
  for (std::size_t i = 0; i < plans.size(); ++i)
    fmt::print("--:|");
  fmt::print("\n");
  print_row("iterations", results, [](const Result& r) { return r.chain.iterations.size() - 1; });
  print_row("first with all correct", results, [](const Result& r) {
    const auto& first = r.statistics.first_correct;
    return first ? fmt::format("{}", *first) : std::string("never");
  });
  print_row("stays with all correct", results, [](const Result& r) { return r.statistics.stays; });
  print_row("longest stay, iterations", results,
            [](const Result& r) { return r.statistics.longest_stay; });
  print_row(fmt::format("visits, with {} balls lost between", k_sharp_drop), results,
            [](const Result& r) { return r.statistics.visits; });
  print_row("correct spellings of which any two differ in half of the balls", results,
            [](const Result& r) {
              return r.statistics.first_correct ? distinct_count(r.orders, r.chain.balls) : 0;
            });
  print_row("iterations with all correct", results, [](const Result& r) {
    return fmt::format("{:.1f}%", 100 * r.statistics.correct_share);
  });
  print_row(fmt::format("change-alls that lowered k by {} or more", k_sharp_drop), results,
            [](const Result& r) { return r.statistics.sharp_change_alls; });
  print_row("of these with a rise of log p(A)", results,
            [](const Result& r) { return r.statistics.change_all_effects.size(); });
  print_row("log p of offsets gained there, mean", results, [](const Result& r) {
    const bool none = r.statistics.change_all_effects.empty();
    return none ? std::string("-") : fmt::format("{:.1f}", r.statistics.effect_log_p_offsets);
  });
  print_row("log p of offsets, mean for each vertex", results,
            [](const Result& r) { return fmt::format("{:.3f}", r.statistics.log_p_offsets); });
  constexpr std::array<const char*, spelling::k_thesis_kinds> k_names{
      "change_all", "change_vertices", "change_ball", "disable_balls", "enable_balls"};
  for (std::size_t kind = 0; kind < k_names.size(); ++kind) {
    print_row(fmt::format("{} accepted", k_names[kind]), results, [&](const Result& r) {
      return fmt::format("{:.1f}%", 100 * static_cast<double>(r.statistics.accepted[kind]) /
                                        static_cast<double>(r.statistics.proposed[kind]));
    });
  }
  print_row("seconds", results, [](const Result& r) { return fmt::format("{:.0f}", r.elapsed_s); });
}

void print_orders(const Plan& plan, const Result& result) {
  if (!plan.draws("2.12") || result.orders.empty()) return;
  const auto orders = most_different(result.orders);
  std::uint32_t most = 0;
  for (const Iteration& iteration : result.chain.iterations)
    most = std::max(most, iteration.filled);
  fmt::print(
      "\n{}, {} kernel: two animations with {} of {} bins filled; {} bins have different "
      "balls\n\n{}",
      plan.what, name_of(plan.kernel), most, result.chain.balls,
      different_bins(orders.first, orders.second), order_text(plan.parameters.pattern, orders));
}

/// Runs the requests of all dice. At most `threads` requests run at a time.
std::vector<ThrownDie> direct_all(const DiceOptions& options, unsigned threads) {
  const std::vector<DieWish> wishes = dice_wishes();
  std::vector<ThrownDie> dice(wishes.size());
  std::atomic<std::uint32_t> next = 0;
  std::vector<std::jthread> workers;
  for (unsigned thread = 0; thread < threads; ++thread) {
    workers.emplace_back([&] {
      for (std::uint32_t nth = next++; nth < wishes.size(); nth = next++)
        dice[nth] = direct_die(nth, wishes[nth], options);
    });
  }
  workers.clear();  // joins
  return dice;
}

/// Makes figure 2.13. Prints each die's cost in two cases: faces are numbered after the throw, or
/// before it.
void throw_dice(const Arguments& arguments) {
  DiceOptions options{.seed = arguments.seed};
  if (arguments.quick) options = {.seed = arguments.seed, .tolerance_mm = 200, .rounds = 2};
  const std::vector<ThrownDie> after = direct_all(options, arguments.threads);
  options.numbering_free = false;
  const std::vector<ThrownDie> before = direct_all(options, arguments.threads);
  fmt::print(
      "\n| die | seed | face up | at x, y (mm) | numbered after the throw: simulations | scans | "
      "seconds | numbered before: simulations | scans | seconds |\n"
      "|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|\n");
  const auto effort = [](const ThrownDie& die) {
    return fmt::format(" {}{} | {} | {:.1f} |", die.simulations,
                       die.motion.empty() ? ", none found" : "", die.scans, die.elapsed_s);
  };
  for (std::size_t i = 0; i < after.size(); ++i) {
    const DieWish& wish = after[i].wish;
    fmt::print("| {} | {} | {} | {}, {} |{}{}\n", i + 1, after[i].seed, wish.face, wish.place_mm.x,
               wish.place_mm.y, effort(after[i]), effort(before[i]));
  }
  if (std::ranges::any_of(after, [](const ThrownDie& die) { return !die.motion.empty(); })) {
    plot::save(dice_composite(after, options), arguments.out + "/figure_2_13.svg",
               {.notes = plot::notes_of(arguments.notes)});
  }
}

void reproduce(const Arguments& arguments) {
  (void)plot::notes_of(arguments.notes);  // reject invalid notes before the long runs
  const std::vector<Plan> plans = plans_of(arguments);
  std::filesystem::create_directories(arguments.out);
  const std::vector<Result> results = run_all(plans, arguments.threads);
  for (std::size_t i = 0; i < plans.size(); ++i)
    draw(plans[i], results[i], arguments);
  if (!plans.empty()) print_table(plans, results, arguments.seed);
  for (std::size_t i = 0; i < plans.size(); ++i)
    print_orders(plans[i], results[i]);
  if (arguments.only.empty() || std::ranges::count(arguments.only, "2.13") > 0)
    throw_dice(arguments);
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{
      "Figures 2.8 to 2.13 of the thesis as SVG; 2.8 to 2.12 each with the kernel that A.2.2 "
      "prints,\n"
      "which is biased, and with the correct one. What 2.4.3 says of the chains, and what each "
      "die\n"
      "of 2.13 took, on stdout."};
  app.name("sleight-figures-2");
  Arguments arguments;
  app.add_option("--out", arguments.out, "Folder of the figures")->capture_default_str();
  app.add_option("--only", arguments.only,
                 "Figures: 2.8, 2.9, 2.10, 2.11, 2.12, 2.13; all if not given")
      ->check(CLI::IsMember({"2.8", "2.9", "2.10", "2.11", "2.12", "2.13"}));
  app.add_option("--iterations", arguments.iterations,
                 "Of each chain; 0: as the thesis, 20000 (2.12: 100000)")
      ->capture_default_str();
  app.add_option("--seed", arguments.seed, "Of all chains")->capture_default_str();
  app.add_option("--threads", arguments.threads, "Chains at a time")
      ->check(CLI::Range(1, 64))
      ->capture_default_str();
  app.add_option("--note", arguments.notes, "NAME=VALUE for the pictures' metadata; repeatable")
      ->allow_extra_args(false);
  app.set_version_flag("--version", "sleight-figures-2 " + std::string(sleight::base::version()));
  app.add_flag("--quick", arguments.quick, "Two balls, few iterations: that it works");
  app.footer("From the project's root:\n  build/release/bin/sleight-figures-2");
  CLI11_PARSE(app, argc, argv);
  try {
    reproduce(arguments);
  } catch (const sleight::base::Error& error) {
    fmt::print(stderr, "sleight-figures-2: {}\n", error.what());
    return static_cast<int>(error.exit_code());
  } catch (const std::exception& error) {
    fmt::print(stderr, "sleight-figures-2: {}\n", error.what());
    return static_cast<int>(sleight::base::ExitCode::bug);
  }
  return 0;
}
