// `sleight-sampling-table` counts each method's independent solutions, for docs/MEASUREMENTS.
//
// The rows "search, in no proportions", "islands" and "chains from a search, judged" exist only for
// staged worlds: balls that spell, and dice (which have no row of judged chains). For balls, these
// rows use the lambda and proposal shares of requests without a sampler, not the scene's lambda.
// Lambda changes how many draws satisfy the constraint, but not the proportions among these draws.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <atomic>
#include <cmath>
#include <functional>
#include <limits>
#include <string>
#include <thread>
#include <vector>

#include "common/base/version.h"
#include "common/math/elementary.h"
#include "tests/support/dice_scenes.h"
#include "tests/thesis/sampling/methods.h"
#include "worker/worlds/ball_2d/ball_2d.h"
#include "worker/worlds/dice/dice.h"
#include "worker/worlds/dice/throw_stages.h"
#include "worker/worlds/spelling/pouring_stages.h"
#include "worker/worlds/spelling/spelling.h"

namespace {

using namespace sleight;
using thesis::Method;
using thesis::Score;
using worlds::ball_2d::Ball2d;
using worlds::dice::Dice;
using worlds::dice::StagedDice;
using worlds::spelling::Spelling;
using worlds::spelling::StagedSpelling;

struct Arguments {
  std::uint64_t simulations = 300'000;
  std::uint64_t throws = 100'000;
  std::uint64_t seed = 1;
  unsigned threads = 2;
  std::string only;
};

struct Row {
  std::string scene;
  std::string method;
  std::function<Score()> run;
  Score score{};
};

/// Sets of proposals. `a_2_2` has the proposals of A.2.2, and `aimed` also has aimed drops. `solo`
/// first tests aimed drops by letting the ball fall alone. `served` has the proposals of requests
/// without a sampler (serve_best() in worker/worlds/spelling/request.cpp).
enum class Kernel { a_2_2, aimed, solo, served };
struct NamedKernel {
  Kernel kernel;
  const char* name;
};
constexpr NamedKernel k_kernels[] = {
    {Kernel::a_2_2, ""}, {Kernel::aimed, ", aimed drops"}, {Kernel::solo, ", solo steps"}};

worlds::spelling::Parameters spelling(const worlds::spelling::Pattern& pattern, double log_lambda,
                                      Kernel kernel) {
  worlds::spelling::Parameters parameters;
  parameters.pattern = pattern;
  parameters.constraint.log_lambda = log_lambda;
  auto& proposal = parameters.proposal;
  if (kernel == Kernel::aimed) {
    proposal.change_all = 0;
    proposal.change_vertices = 0.1;
    proposal.change_ball = 0.3;
    proposal.disable_balls = proposal.enable_balls = 0.1;
    proposal.aim_ball = proposal.scatter_ball = 0.2;
  } else if (kernel == Kernel::solo) {
    proposal.change_all = 0;
    proposal.change_vertices = 0.01;
    proposal.change_ball = 0.03;
    proposal.disable_balls = proposal.enable_balls = 0.01;
    proposal.aim_ball = proposal.scatter_ball = 0.47;
    proposal.solo_steps = 10;
  } else if (kernel == Kernel::served) {
    proposal.change_all = 0.01;
    proposal.change_vertices = 0.25;
    proposal.change_ball = 0.14;
    proposal.disable_balls = proposal.enable_balls = 0.02;
    proposal.aim_ball = proposal.scatter_ball = 0.28;
    proposal.vertex_redraw = 1;
    proposal.ball_sd_m = 0.002;
  }
  return parameters;
}

/// Draws an undirected box, and random drops of all balls.
worlds::spelling::State natural_throw(const Spelling& world, random::Stream& stream) {
  worlds::spelling::State state = world.draw_prior(stream);
  const auto& half_m = world.prior().drop_half_m;
  for (std::size_t ball = 0; ball < state.active.size(); ++ball) {
    state.active[ball] = 1;
    const double x = (2 * stream.uniform() - 1) * half_m.x();
    const double y = (2 * stream.uniform() - 1) * half_m.y();
    state.drops_m[ball] = {x, y};
  }
  return state;
}

struct Named {
  Method method;
  const char* name;
};
constexpr Named k_methods[] = {{Method::parallel_tempering, "parallel tempering"},
                               {Method::simulated_tempering, "simulated tempering"},
                               {Method::tempered_transitions, "tempered transitions"},
                               {Method::annealed_importance, "annealed importance sampling"}};

template <class World, class Parameters>
void add_plans(const Arguments& arguments, const std::string& scene, const std::string& kernel,
               const Parameters& parameters, std::uint32_t iterations_per_scan,
               std::vector<Row>& rows) {
  for (const Named& each : k_methods) {
    rows.push_back({scene, each.name + kernel, [=] {
                      const World world(parameters);
                      const auto plan =
                          thesis::plan_of(each.method, thesis::ladder_for(world, arguments.seed));
                      return thesis::carried_out<World>(
                          *plan, parameters,
                          {.iterations_per_scan = iterations_per_scan, .thin = 1U << 30U},
                          arguments.simulations);
                    }});
  }
}

/// Measures islands. A scan has `iterations_per_scan` proposals and three free islands.
template <run::StagedWorld World, class Parameters>
Row islands_row(const Arguments& arguments, const std::string& scene, const Parameters& parameters,
                std::uint32_t iterations_per_scan) {
  return {scene, "islands", [=] {
            return thesis::carried_out<World>(*thesis::islands(arguments.seed), parameters,
                                              {.iterations_per_scan = iterations_per_scan,
                                               .thin = 1U << 30U,
                                               .particles = thesis::k_particles},
                                              arguments.simulations);
          }};
}

template <run::StagedWorld World, class Parameters>
Row search_row(const Arguments& arguments, const std::string& scene, const Parameters& parameters,
               thesis::LoneSimulations lone) {
  return {scene, "search, in no proportions", [=] {
            return thesis::searched<World>(parameters, arguments.seed, arguments.simulations, lone);
          }};
}

/// Adds the rows of staged methods. Options are those of requests without a sampler (serve_best()).
/// Unlike in these requests, islands and judged chains run for any number of balls.
void add_spelling_in_stages(const Arguments& arguments, const std::string& scene,
                            const worlds::spelling::Pattern& pattern, std::vector<Row>& rows) {
  const std::uint32_t balls = pattern.count();
  const double log_balls = math::log(balls);
  const auto strict = spelling(pattern, std::round(6 + log_balls), Kernel::served);
  rows.push_back(
      search_row<StagedSpelling>(arguments, scene, strict, thesis::LoneSimulations::left_out));
  rows.push_back(islands_row<StagedSpelling>(arguments, scene, strict, 4 * balls));
  rows.push_back({scene, "chains from a search, judged", [=] {
                    const auto judged = StagedSpelling(strict).burn_in_values();
                    return thesis::carried_out<StagedSpelling>(
                        *thesis::judged_chains(arguments.seed, judged), strict,
                        {.iterations_per_scan = balls,
                         .thin = 1U << 30U,
                         .starts_by_search = true,
                         .is_judged = true},
                        arguments.simulations);
                  }});
}

void add_spelling(const Arguments& arguments, const std::string& scene,
                  const worlds::spelling::Pattern& pattern, double log_lambda,
                  std::vector<Row>& rows) {
  rows.push_back({scene, "blind throws", [=] {
                    return thesis::throws<Spelling>(spelling(pattern, log_lambda, Kernel::a_2_2),
                                                    arguments.seed, arguments.throws,
                                                    natural_throw);
                  }});
  for (const NamedKernel& each : k_kernels) {
    const auto parameters = spelling(pattern, log_lambda, each.kernel);
    const std::string kernel = each.name;
    // If steps are solo steps, one iteration already makes one or two simulations.
    const std::uint32_t iterations_per_scan = each.kernel == Kernel::solo ? 1 : 2;
    rows.push_back({scene, "Algorithm 2.1, restarted" + kernel, [=] {
                      return thesis::restarted_chains<Spelling>(parameters, arguments.seed,
                                                                arguments.simulations);
                    }});
    add_plans<Spelling>(arguments, scene, kernel, parameters, iterations_per_scan, rows);
    rows.push_back({scene, "parallel tempering, short ladders" + kernel, [=] {
                      const auto ladder = thesis::ladder_for(Spelling(parameters), arguments.seed);
                      return thesis::carried_out<Spelling>(
                          *thesis::short_ladders(ladder, arguments.simulations), parameters,
                          {.iterations_per_scan = iterations_per_scan, .thin = 1U << 30U},
                          arguments.simulations);
                    }});
  }
  add_spelling_in_stages(arguments, scene, pattern, rows);
}

/// Adds the rows of dice. For undirected throws, faces are numbered before the throw.
void add_dice(const Arguments& arguments, const std::string& scene,
              const worlds::dice::Parameters& parameters, std::uint32_t iterations_per_scan,
              std::vector<Row>& rows) {
  rows.push_back({scene, "blind throws", [=] {
                    auto numbered = parameters;
                    numbered.numbering = worlds::dice::Numbering::fixed;
                    return thesis::throws<Dice>(
                        numbered, arguments.seed, arguments.throws,
                        [](const auto& world, auto& stream) { return world.draw_prior(stream); });
                  }});
  rows.push_back({scene, "Algorithm 2.1, restarted", [=] {
                    return thesis::restarted_chains<Dice>(parameters, arguments.seed,
                                                          arguments.simulations);
                  }});
  add_plans<Dice>(arguments, scene, "", parameters, iterations_per_scan, rows);
  rows.push_back(
      search_row<StagedDice>(arguments, scene, parameters, thesis::LoneSimulations::counted));
  const auto dice = static_cast<std::uint32_t>(parameters.world.dice.size());
  rows.push_back(islands_row<StagedDice>(arguments, scene, parameters, 10 * dice));
}

std::vector<Row> all_rows(const Arguments& arguments) {
  std::vector<Row> rows;
  worlds::ball_2d::Parameters ball;
  ball.constraint.sigma_diameters = ball.constraint.tolerance_diameters = 0.001;
  rows.push_back({"ball", "blind throws", [=] {
                    return thesis::throws<Ball2d>(
                        ball, arguments.seed, arguments.throws,
                        [](const auto& world, auto& stream) { return world.draw_prior(stream); });
                  }});
  rows.push_back({"ball", "Algorithm 2.1, restarted", [=] {
                    return thesis::restarted_chains<Ball2d>(ball, arguments.seed,
                                                            arguments.simulations);
                  }});
  add_plans<Ball2d>(arguments, "ball", "", ball, 2, rows);
  add_spelling(arguments, "HI", worlds::spelling::hi(), 6, rows);
  add_spelling(arguments, "ACM",
               worlds::spelling::pattern_of_word("ACM", worlds::spelling::Font::rows_5).value(),
               7.25, rows);
  add_dice(arguments, "die", tests::die(0.005, 0.005, false), 2, rows);
  add_dice(arguments, "die_exact", tests::die(0.002, 0.001, true), 2, rows);
  add_dice(arguments, "six_dice", tests::six_dice(), 20, rows);
  if (!arguments.only.empty())
    std::erase_if(rows, [&](const Row& row) { return row.scene != arguments.only; });
  return rows;
}

void run_all(std::vector<Row>& rows, unsigned threads) {
  std::atomic<std::size_t> next = 0;
  std::vector<std::jthread> workers;
  for (unsigned thread = 0; thread < threads; ++thread) {
    workers.emplace_back([&] {
      for (std::size_t i = next++; i < rows.size(); i = next++) {
        rows[i].score = rows[i].run();
        fmt::print(stderr, "{} of {}: {}, {}\n", i + 1, rows.size(), rows[i].scene, rows[i].method);
      }
    });
  }
}

void print(const std::vector<Row>& rows) {
  fmt::print(
      "| scene | method | simulations | solutions | per 10^4 simulations | per core-second "
      "| of Algorithm 2.1 |\n|---|---|--:|--:|--:|--:|--:|\n");
  double baseline = std::numeric_limits<double>::quiet_NaN();
  for (const Row& row : rows) {
    const auto solutions = static_cast<double>(row.score.solutions);
    const double rate = 1e4 * solutions / static_cast<double>(row.score.simulations);
    if (row.method == "Algorithm 2.1, restarted") baseline = rate;
    if (row.method == "blind throws") baseline = std::numeric_limits<double>::quiet_NaN();
    fmt::print("| {} | {} | {} | {} | {:.2f} | {:.3g} | {} |\n", row.scene, row.method,
               row.score.simulations, row.score.solutions, rate, solutions / row.score.cpu_s,
               !(baseline > 0) ? "-" : fmt::format("{:.2f}", rate / baseline));
  }
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{
      "Independent satisfying solutions by each method: the table of docs/MEASUREMENTS.\n"
      "Dice and balls that spell also have rows of methods that act in stages: a search, whose\n"
      "finds are in no proportions, and islands; balls that spell also chains from a search, "
      "judged."};
  app.set_version_flag("--version", "sleight-sampling-table " + std::string(base::version()));
  Arguments arguments;
  app.add_option("--simulations", arguments.simulations, "Of each method and scene")
      ->capture_default_str();
  app.add_option("--throws", arguments.throws, "Blind ones")->capture_default_str();
  app.add_option("--seed", arguments.seed)->capture_default_str();
  app.add_option("--threads", arguments.threads)->capture_default_str();
  app.add_option("--only", arguments.only, "One scene")
      ->check(CLI::IsMember({"ball", "HI", "ACM", "die", "die_exact", "six_dice"}));
  app.footer(
      "Examples:\n  sleight-sampling-table\n"
      "  sleight-sampling-table --only HI --simulations 50000");
  CLI11_PARSE(app, argc, argv);
  std::vector<Row> rows = all_rows(arguments);
  run_all(rows, std::max(1U, arguments.threads));
  print(rows);
  return 0;
}
