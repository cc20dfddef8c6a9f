#include "worker/worlds/spelling/request.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include <fmt/format.h>

#include "common/math/elementary.h"
#include "common/request/settled.h"
#include "common/request/text.h"
#include "worker/worlds/spelling/pouring_stages.h"

namespace sleight::worlds::spelling {
namespace {

constexpr std::array<request::Named<Font>, 2> k_fonts{
    {{"5 rows", Font::rows_5}, {"7 rows", Font::rows_7}}};

constexpr std::array<request::Named<Kernel>, 2> k_kernels{
    {{"correct", Kernel::correct}, {"thesis", Kernel::thesis}}};

/// Maximum bytes of an island, per worker.
constexpr std::uint64_t k_island_bytes_max = std::uint64_t{1} << 30U;
/// Bytes per ball in a simulated pouring. The bytes include the history. Measured: 6.5 to 7.1 kB
/// with I, HI and SLEIGHT.
constexpr std::uint64_t k_bytes_of_ball = 7200;

/// Bytes of a particle. A particle stores its pouring, and which drops of the pool it has used.
std::uint64_t prefix_bytes(std::uint64_t balls) {
  return balls * (k_bytes_of_ball + std::max<std::uint64_t>(k_drops_per_bin_min, balls));
}

/// Maximum particles. Resampling needs memory for twice the prefixes.
std::uint64_t particles_max(std::uint64_t balls) {
  return k_island_bytes_max / (2 * prefix_bytes(balls));
}

/// Minimum of rest_speed and minimum of rest_time, both in multiples of bounce_end.
constexpr double k_bounce_ends_min = 2;

/// Binds a length of at most 1 m.
void length_mm(request::Binder& binder, std::string_view key, double& value_m, double minimum_mm,
               std::string_view help) {
  binder.length_mm(key, value_m, {.minimum = minimum_mm, .maximum = 1000, .help = help});
}

/// Returns the pattern of the given word or bitmap. If neither is given, returns the thesis's HI.
/// On an error, returns nothing.
std::optional<Pattern> given_pattern(request::Binder& world, const std::string& word,
                                     const std::string& bitmap, Font font) {
  const char* key = word.empty() ? "bitmap" : "word";
  Pattern pattern = hi();
  if (!word.empty() || !bitmap.empty()) {
    const auto given = word.empty() ? pattern_of_rows(bitmap) : pattern_of_word(word, font);
    if (!given) {
      world.error(key, given.error());
      return std::nullopt;
    }
    pattern = given.value();
    if (pattern.count() == 0) {
      world.error(key, "the pattern has no designated bins");
      return std::nullopt;
    }
  }
  if (pattern.columns > k_columns_max || pattern.rows > k_rows_max) {
    world.error(key, fmt::format("the pattern needs {} x {} bins, but the maximum is {} x {}",
                                 pattern.columns, pattern.rows, k_columns_max, k_rows_max));
    return std::nullopt;
  }
  return pattern;
}

/// Returns the pattern in the middle of a box of the given size. If the pattern doesn't fit,
/// returns nothing. `key` is the pattern's key.
std::optional<Pattern> pattern_in_box(request::Binder& world, const Pattern& pattern,
                                      std::optional<std::uint32_t> columns,
                                      std::optional<std::uint32_t> rows, const char* key) {
  const auto fits = [&](const char* size, std::uint32_t wanted, std::uint32_t needed) {
    if (wanted >= needed) return true;
    world.error(size, fmt::format("must be at least {} for this pattern", needed));
    return false;
  };
  const std::uint32_t all_columns = columns.value_or(pattern.columns);
  const std::uint32_t all_rows = rows.value_or(pattern.rows);
  if (!fits("columns", all_columns, pattern.columns) || !fits("rows", all_rows, pattern.rows))
    return std::nullopt;
  if (all_columns * all_rows < 2) {
    world.error(key, "a box needs at least 2 bins; add columns or rows");
    return std::nullopt;
  }
  return centred(pattern, all_columns, all_rows);
}

void bind_pattern(request::Binder& world, Pattern& pattern) {
  std::string word;
  std::string bitmap;
  Font font = Font::rows_5;
  std::optional<std::uint32_t> columns;
  std::optional<std::uint32_t> rows;
  world.text(
      "word", word,
      {.characters_max = 20,
       .help = "word to spell (A to Z, 0 to 9 and spaces); default if no bitmap is set: HI as in "
               "the thesis, smaller than in this font"});
  world.choice<Font>("font", font, k_fonts, "height of the word's letters");
  world.text("bitmap", bitmap,
             {.characters_max = (k_columns_max + 2) * (k_rows_max + 2),
              .help = "pattern instead of a word: rows of '.' and '#', one row per line"});
  world.optional_integer<std::uint32_t>(
      "columns", columns,
      {.minimum = 1,
       .maximum = k_columns_max,
       .help = "number of columns of bins; default: the pattern's width"});
  world.optional_integer<std::uint32_t>(
      "rows", rows,
      {.minimum = 1,
       .maximum = k_rows_max,
       .help = "number of rows of bins; default: the pattern's height"});
  if (!world.all_valid({"word", "bitmap", "font"})) return;
  if (!word.empty() && !bitmap.empty())
    return world.error("bitmap", "set either `word` or `bitmap`, not both");
  const std::optional<Pattern> given = given_pattern(world, word, bitmap, font);
  if (!given || !world.valid("columns") || !world.valid("rows")) return;
  const char* key = word.empty() ? "bitmap" : "word";
  if (const auto whole = pattern_in_box(world, *given, columns, rows, key)) pattern = *whole;
}

void check_sizes(request::Binder& world, const WorldParameters& p) {
  if (!world.all_valid({"bin_mm", "partition_mm", "partition_height_mm", "drop_height_mm",
                        "vertex_sd_mm", "dome_mm", "ball_diameter_mm"}))
    return;
  const auto mm = [](double value_m) { return fmt::format("{:.6g}", 1e3 * value_m); };
  // Leave some room on each side; otherwise a box that is one bin wide has no drop region.
  constexpr double k_room_m = 1e-5;
  if (p.ball_diameter_m > p.bin_m - k_room_m)
    return world.error("ball_diameter_mm", fmt::format("must be at most {} ({} less than bin_mm)",
                                                       mm(p.bin_m - k_room_m), mm(k_room_m)));
  constexpr double k_slack = 1 + 1e-9;
  const double most_sd_m = 0.1 * std::min(p.partition_m, p.partition_height_m);
  if (p.vertex_sd_m > k_slack * most_sd_m)
    return world.error(
        "vertex_sd_mm",
        fmt::format("must be at most {} (a tenth of partition_mm and of partition_height_mm)",
                    mm(most_sd_m)));
  const double least_drop_m = p.partition_height_m + 10 * p.vertex_sd_m;
  if (p.drop_height_m < least_drop_m)
    return world.error(
        "drop_height_mm",
        fmt::format("must be at least {} (partition_height_mm plus 10 times vertex_sd_mm)",
                    mm(least_drop_m)));
  constexpr double k_thinnest = 1000;
  if (p.bin_m > k_thinnest * p.partition_m)
    return world.error("partition_mm", fmt::format("must be at least {} (a thousandth of bin_mm)",
                                                   mm(p.bin_m / k_thinnest)));
  if (p.dome_m > p.partition_height_m)
    return world.error("dome_mm", fmt::format("must be at most {} (partition_height_mm)",
                                              mm(p.partition_height_m)));
  // A ball at rest touches two partitions and the dome's slope.
  const double radius_m = 0.5 * p.ball_diameter_m;
  const double slope = 2 * p.dome_m / p.bin_m;
  const double lowest_m = radius_m * std::sqrt(1 + slope * slope) +
                          p.dome_m * (1 - (p.bin_m - p.ball_diameter_m) / p.bin_m);
  if (p.partition_height_m <= lowest_m) {
    world.error("partition_height_mm",
                fmt::format("must be above {}, the height of a resting ball's centre (computed "
                            "from ball_diameter_mm, dome_mm and bin_mm)",
                            mm(lowest_m)));
  }
}

void bind_world(request::Binder& world, WorldParameters& p) {
  length_mm(world, "bin_mm", p.bin_m, 1, "inner side length of a bin");
  world.length_mm("partition_mm", p.partition_m,
                  {.minimum = 0.1, .maximum = 30, .help = "thickness of the partitions"});
  length_mm(world, "partition_height_mm", p.partition_height_m, 0.1, "height of the partitions");
  length_mm(world, "box_height_mm", p.box_height_m, 1, "height of the box's walls");
  length_mm(world, "drop_height_mm", p.drop_height_m, 1,
            "height of a ball's lowest point at the start of its drop");
  length_mm(world, "vertex_sd_mm", p.vertex_sd_m, 0.001,
            "standard deviation of each coordinate of a partition's vertices");
  length_mm(world, "dome_mm", p.dome_m, 0.001,
            "height of the centre of a bin's floor above the floor's rim");
  length_mm(world, "ball_diameter_mm", p.ball_diameter_m, 0.5, "diameter of a ball");
  world.number("density_kgpm3", p.density_kgpm3,
               {.minimum = 1,
                .maximum = 30000,
                .unit = "kg/m3",
                .help = "density of the balls; glass: 2500"});
  world.number("drop_interval_s", p.drop_interval_s,
               {.minimum = 0.001, .maximum = 10, .unit = "s", .help = "time between drops"});
  world.number("restitution", p.restitution,
               {.minimum = 0, .maximum = 1, .help = "coefficient of restitution of all impacts"});
  world.number("friction", p.friction,
               {.minimum = 0, .maximum = 10, .help = "friction coefficient of all contacts"});
  world.number(
      "gravity_mps2", p.gravity_mps2,
      {.minimum = 0.01, .maximum = 1000, .unit = "m/s2", .help = "gravitational acceleration"});
  world.number(
      "bounce_end", p.bounce_end,
      {.minimum = 0.001,
       .maximum = 0.1,
       .help = "separation speed below which bounces end, in units of sqrt(gravity x diameter)"});
  world.number("rest_speed", p.rest_speed,
               {.minimum = 0.002,
                .maximum = 0.5,
                .help = "speed below which a balanced ball comes to rest, in units of sqrt(gravity "
                        "x diameter)"});
  // If rest_speed were lower, the slowest bounces would keep a ball from resting.
  if (world.all_valid({"bounce_end", "rest_speed"}) &&
      p.rest_speed < k_bounce_ends_min * p.bounce_end) {
    world.error("rest_speed",
                fmt::format("must be at least {:g} ({} times bounce_end), found {:g}",
                            k_bounce_ends_min * p.bounce_end, k_bounce_ends_min, p.rest_speed));
  }
  world.number("rest_time", p.rest_time,
               {.minimum = 0.01,
                .maximum = 10,
                .help = "time below rest_speed after which a ball comes to rest, in units of "
                        "sqrt(diameter / gravity)"});
  // If rest_time were shorter, a touch would expire before the ball's next bounce, and the ball
  // would never be in balance.
  if (world.all_valid({"bounce_end", "rest_time"}) &&
      p.rest_time < k_bounce_ends_min * p.bounce_end) {
    world.error("rest_time",
                fmt::format("must be at least {:g} ({} times bounce_end, the "
                            "duration of the slowest bounces), found {:g}",
                            k_bounce_ends_min * p.bounce_end, k_bounce_ends_min, p.rest_time));
  }
  world.number("time_limit_s", p.time_limit_s,
               {.minimum = 0.01,
                .maximum = 100,
                .unit = "s",
                .help = "time limit after the last drop, for balls that do not come to rest"});
  check_sizes(world, p);
}

std::optional<std::string> value_of(const request::Binder& sampler, std::string_view key) {
  const auto at = std::ranges::find(
      sampler.keys(), key, [](const auto& bound) { return std::string_view(bound.spec.key); });
  if (at == sampler.keys().end() || at->value.empty()) return std::nullopt;
  return at->value;
}

void check_memory(request::Binder& sampler, std::uint32_t balls) {
  if (!sampler.valid("method") || !sampler.valid("particles")) return;
  if (value_of(sampler, "method") != "\"sequential\"") return;
  const std::optional<std::string> given = value_of(sampler, "particles");
  const std::uint64_t particles = given ? std::stoull(*given) : request::k_particles;
  if (particles <= particles_max(balls)) return;
  sampler.error("particles",
                fmt::format("{} particles of {} balls need {} MB per worker, but the limit is {} "
                            "MB; use at most {} particles",
                            particles, balls, (2 * particles * prefix_bytes(balls)) >> 20U,
                            k_island_bytes_max >> 20U, particles_max(balls)));
}

/// For the thesis kernel, refuses methods other than the thesis's. Other methods require a kernel
/// that has the right distribution.
void check_kernel(request::Binder& sampler, Kernel kernel) {
  if (kernel != Kernel::thesis || !sampler.valid("method")) return;
  if (value_of(sampler, "start") == "\"search\"") {
    sampler.error(
        "kernel",
        "kernel \"thesis\" is biased, so its burn-in can't be judged; set start = \"prior\"");
    return;
  }
  const std::string method = value_of(sampler, "method").value_or("");
  if (method != "\"metropolis_hastings\"") {
    sampler.error(
        "kernel",
        fmt::format(
            "kernel \"thesis\" is biased and requires method \"metropolis_hastings\", found {}{}",
            method, sampler.given("method") ? "" : " (the default); set method"));
  }
}

void bind_proposal(request::Binder& sampler, ProposalParameters& p) {
  sampler.choice<Kernel>("kernel", p.kernel, k_kernels,
                         "proposal ratios; \"thesis\": the biased ratios printed in the thesis "
                         "(A.2.2), only for reproducing its figures");
  check_kernel(sampler, p.kernel);
  sampler.shares(
      {{"change_all", p.change_all, "share of proposals that redraw everything"},
       {"change_vertices", p.change_vertices, "share of proposals that move partition vertices"},
       {"change_ball", p.change_ball, "share of proposals that drop one ball at a different place"},
       {"disable_balls", p.disable_balls, "share of proposals that remove balls"},
       {"enable_balls", p.enable_balls,
        "share of proposals that add balls; must equal disable_balls"},
       {"aim_ball", p.aim_ball, "share of proposals that drop a loose ball near an empty bin"},
       {"scatter_ball", p.scatter_ball,
        "share of proposals that take a ball out of a bin that it fills, and drop it at a random "
        "place; these proposals reverse aim_ball"}});
  sampler.number("vertex_probability", p.vertex_probability,
                 {.minimum = 0,
                  .maximum = 1,
                  .help = "probability that a change_vertices proposal moves a given vertex"});
  length_mm(sampler, "vertex_move_sd_mm", p.vertex_sd_m, 1e-6,
            "standard deviation of each coordinate of a vertex move");
  p.vertex_redraw = 0;
  sampler.optional_number(
      "vertex_redraw", p.vertex_redraw,
      {.minimum = 0,
       .above_minimum = true,
       .maximum = 1,
       .help =
           "share of change_vertices proposals that redraw one vertex from the prior; default: 0"});
  length_mm(sampler, "ball_move_sd_mm", p.ball_sd_m, 0.001,
            "standard deviation of the distance by which change_ball moves a drop");
  sampler.number("flip_probability", p.flip_probability,
                 {.minimum = 0,
                  .above_minimum = true,
                  .maximum = 1,
                  .below_maximum = true,
                  .help = "probability that an enable_balls proposal adds a given ball, or a "
                          "disable_balls proposal removes it"});
  sampler.integer("solo_steps", p.solo_steps,
                  {.minimum = 0,
                   .maximum = k_solo_steps_max,
                   .help = "number of proposals per iteration; each is first tested by a "
                           "simulation of only the balls that it changes; 0: off, one ordinary "
                           "proposal per iteration"});
  if (!sampler.all_valid({"change_all", "change_vertices", "change_ball", "disable_balls",
                          "enable_balls", "aim_ball", "scatter_ball", "solo_steps"}))
    return;
  if (p.disable_balls != p.enable_balls)
    sampler.error("enable_balls",
                  "must equal disable_balls, because the two proposals reverse each other");
  if ((p.aim_ball > 0) != (p.scatter_ball > 0))
    sampler.error(
        "scatter_ball",
        "must be used together with aim_ball, because the two proposals reverse each other");
  for (const auto& [key, value] :
       {std::pair{"aim_ball", p.aim_ball}, std::pair{"vertex_redraw", p.vertex_redraw},
        std::pair{"solo_steps", static_cast<double>(p.solo_steps)}}) {
    if (p.kernel == Kernel::thesis && value > 0)
      sampler.error(
          key,
          "can't be used with kernel \"thesis\", which implements A.2.2 of the thesis as printed");
  }
}

/// Above this number of balls, weights of 32-particle islands differ so much that chains of islands
/// hardly move. Longer words use chains that start from a search.
constexpr std::uint32_t k_balls_by_islands_max = 20;

/// Numbers of scans and particles in a tour of islands. Measured with HI in docs/MEASUREMENTS.
constexpr std::uint32_t k_tour_scans = 16;
constexpr std::uint32_t k_tour_particles = 32;
/// Number of chains. There is one chain more than the usual number of solutions, because five of
/// six draws of HI satisfy.
constexpr std::uint32_t k_tour_chains = 6;

void settle_log_lambda(request::Binder& constraint, Parameters& parameters, double chosen) {
  if (constraint.given("log_lambda")) return;
  parameters.constraint.log_lambda = chosen;
  constraint.settle("log_lambda", request::toml_number(chosen));
}

/// Three particles per ball. If there are more balls, more can go wrong. The number is rounded up
/// to a multiple of 16, and is at least 32 and at most 96. Measured in docs/MEASUREMENTS.
std::uint32_t particles_for_odds(std::uint32_t balls) {
  const std::uint32_t wanted = std::clamp((3 * balls + 15) / 16 * 16, 32U, 96U);
  return static_cast<std::uint32_t>(std::min<std::uint64_t>(wanted, particles_max(balls)));
}

/// Settings for odds. The first island already estimates odds, so islands need no chain.
void settle_odds(request::Settled& settled, std::uint32_t balls,
                 request::SamplerParameters& sampler) {
  settled.method(request::Method::sequential, "sequential");
  settled.count("particles", sampler.particles, particles_for_odds(balls));
}

/// Settings for chains of islands. If solutions are requested, chains restart for each solution;
/// otherwise they continue. Helped balls (pouring_stages.h) have large weights, but islands find
/// too few. Further steps of a tour find more.
void settle_islands(request::Settled& settled, std::uint32_t balls, const request::StopRule& stop,
                    request::SamplerParameters& sampler) {
  settled.method(request::Method::sequential, "sequential");
  settled.chains(k_tour_chains, 1, 4 * balls);
  settled.count("particles", sampler.particles, k_tour_particles);
  if (stop.scans || stop.rounds) {
    settled.count("burn_in_rounds", sampler.burn_in_rounds, 4);
  } else {
    settled.count("tour_scans", sampler.tour_scans, k_tour_scans);
  }
}

/// Number of scans by which a chain relaxes a find. docs/MEASUREMENTS shows how similar the result
/// and the find still are.
std::uint32_t relax_scans_for(std::uint32_t balls) {
  return 90 + 3 * balls / 2;
}

struct Moves {
  double change_all = 0.01;
  double change_vertices = 0.25;
  double change_ball = 0.14;
  double disable_and_enable = 0.02;  ///< each
  double aim_and_scatter = 0.28;     ///< each
  double ball_move_sd_mm = 2;
};

/// A find has no helped balls, and helped balls are usually dropped above a neighbouring bin. So
/// most proposals move a drop about as far as the next bin.
Moves moves_that_relax(const WorldParameters& world) {
  constexpr double k_bins = 1.2;
  return {.change_all = 0,
          .change_vertices = 0.1,
          .change_ball = 0.6,
          .disable_and_enable = 0,
          .aim_and_scatter = 0.15,
          .ball_move_sd_mm = std::round(k_bins * 1e3 * (world.bin_m + world.partition_m))};
}

void settle_proposals(request::Settled& settled, const Moves& moves, ProposalParameters& p) {
  settled.number("change_all", p.change_all, moves.change_all);
  settled.number("change_vertices", p.change_vertices, moves.change_vertices);
  settled.number("change_ball", p.change_ball, moves.change_ball);
  settled.number("disable_balls", p.disable_balls, moves.disable_and_enable);
  settled.number("enable_balls", p.enable_balls, moves.disable_and_enable);
  settled.number("aim_ball", p.aim_ball, moves.aim_and_scatter);
  settled.number("scatter_ball", p.scatter_ball, moves.aim_and_scatter);
  settled.number("vertex_redraw", p.vertex_redraw, 1);
  double ball_move_sd_mm = 0;
  settled.number("ball_move_sd_mm", ball_move_sd_mm, moves.ball_move_sd_mm);
  p.ball_sd_m = ball_move_sd_mm / 1e3;
}

/// Chooses the sampler if the request doesn't name one. docs/SAMPLING explains the numbers.
void serve_best(request::WorldSections& sections, request::SamplerParameters& sampling,
                const request::StopRule& stop, Parameters& parameters) {
  request::Settled settled(sections.sampler, sampling);
  const std::uint32_t balls = parameters.pattern.count();
  // Lambda is so strict that most draws satisfy: each missing ball divides p_c by about e^6 times
  // the number of balls. If there are few balls, finds relax sooner with a smaller lambda.
  const double strict = std::round(6 + math::log(balls));
  const bool is_loose = stop.takes && balls <= k_balls_by_islands_max;
  settle_log_lambda(sections.constraint, parameters, is_loose ? strict - 1 : strict);
  // Judged chains determine their number of rounds themselves, and estimate no odds. A scan of a
  // chain has one proposal per ball.
  if (stop.takes) {
    settled.relax(balls, relax_scans_for(balls));
  } else if (stop.odds) {
    settle_odds(settled, balls, sampling);
  } else if (balls <= k_balls_by_islands_max) {
    settle_islands(settled, balls, stop, sampling);
  } else {
    settled.search();
    if (stop.rounds) {
      settled.method(request::Method::parallel_tempering, "parallel_tempering");
      settled.chains(2, 32, balls);
    } else {
      // Each judged chain must burn in and usually yields one solution, so their number is the
      // default number of solutions.
      settled.method(request::Method::metropolis_hastings, "metropolis_hastings");
      settled.chains(5, 32, balls);
    }
  }
  ProposalParameters& p = parameters.proposal;
  settle_proposals(settled, stop.takes ? moves_that_relax(parameters.world) : Moves{}, p);
}

void bind(request::WorldSections& sections, Parameters& parameters) {
  bind_pattern(sections.world, parameters.pattern);
  bind_world(sections.world, parameters.world);
  sections.constraint.number(
      "log_lambda", parameters.constraint.log_lambda,
      {.minimum = 0,
       .maximum = 100,
       .help = "natural logarithm of lambda; p_c = lambda^k for k filled bins"});
  bind_proposal(sections.sampler, parameters.proposal);
  if (sections.world.valid("word") && sections.world.valid("bitmap"))
    check_memory(sections.sampler, parameters.pattern.count());
}

}  // namespace

request::WorldBinding request_binding() {
  return request::bind_world<Parameters>(
      "spelling", "balls are dropped into a box and come to rest in the bins that spell a word",
      &bind, &serve_best);
}

}  // namespace sleight::worlds::spelling
