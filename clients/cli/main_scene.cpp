#include "clients/cli/main_scene.h"

#include <optional>
#include <utility>
#include <variant>

#include <fmt/format.h>

#include "clients/cli/given_request.h"
#include "clients/cli/main_run.h"
#include "clients/pictures/animation_figures.h"
#include "clients/pictures/strip_figure.h"
#include "clients/plot/save.h"
#include "clients/terminal/output.h"
#include "common/base/clock.h"
#include "common/base/error.h"
#include "common/json/value.h"
#include "common/request/sets.h"
#include "worker/worlds/user_scene/check/check.h"
#include "worker/worlds/user_scene/look/look.h"
#include "worker/worlds/user_scene/request.h"
#include "worker/worlds/user_scene/user_scene.h"

namespace sleight::programs {
namespace {

namespace user_scene = worlds::user_scene;
using user_scene::Parameters;

/// Without --draws: maximum number of prior draws, and maximum time for them.
constexpr std::uint64_t k_draws_max = 1000;
constexpr double k_draws_s = 0.3;
/// With --draws, progress is printed at this interval.
constexpr double k_progress_s = 5;
constexpr std::size_t k_drawn_max = 9;

/// Reads the request. Prints its errors and returns nothing if it has any.
std::optional<Parameters> read_scene(const SceneArguments& arguments) {
  if (arguments.path.empty())
    throw base::Error(base::ExitCode::usage,
                      "scene check: expected the name of a request, found an empty name");
  const cli::GivenRequest given = cli::given_request(arguments.path, {}, std::nullopt);
  const std::vector<request::WorldBinding> worlds{user_scene::request_binding()};
  const auto sets = request::plain_sets(arguments.sets);
  const auto read = sets ? request::read_request_with(given.text, given.name, worlds, sets.value())
                         : std::move(sets).error();
  if (read) return request::parameters_of<Parameters>(read.value());
  for (const request::Diagnostic& error : read.error())
    terminal::complain(request::to_string(error));
  return std::nullopt;
}

pictures::ShownAnimation shown(const user_scene::BuiltScene& built, const scene::Scene& look,
                               const physics::Recording& recording, std::string title) {
  auto motion =
      motion::Animation::of(user_scene::segments_of(built, recording), look.features.size());
  if (!motion) throw base::Error(motion.error());
  return {.title = std::move(title), .motion = std::move(motion).value()};
}

/// Draws the scene's simulation as a strip. If something is uncertain, draws prior draws. REQUIRES:
/// the report has a simulation, or prior draws that can be simulated.
void draw(const user_scene::UserScene& world, const user_scene::SceneReport& report,
          const SceneArguments& arguments) {
  const Parameters& parameters = world.parameters();
  const user_scene::BuiltScene& built = *parameters.built;
  const scene::Scene look = user_scene::look_of(parameters);
  std::vector<pictures::ShownAnimation> throws;
  const std::uint64_t draws = report.draws ? report.draws->count : 0;
  for (std::uint64_t nth = 0; throws.size() < k_drawn_max && nth < draws; ++nth) {
    const user_scene::Animation one = world.animate(sampling::nth_prior_draw(world, nth));
    if (!one.outcome.is_animation()) continue;
    const bool met = world.satisfied(one.outcome) && !parameters.constraints.empty();
    throws.push_back(shown(built, look, one.recording,
                           fmt::format("prior draw {}{}", nth, met ? ", as requested" : "")));
  }
  if (!throws.empty())
    return plot::save(pictures::animation_figure(arguments.path, look, throws), arguments.drawing);
  const user_scene::NominalRun& run = report.run.value();
  pictures::ShownAnimation strip = shown(built, look, *run.recording, "");
  const bool is_over = run.end == user_scene::RunEnd::all_ended;
  const double end_s = is_over ? strip.motion.end_s() : run.end_s;
  strip.title = fmt::format("simulated to {:.2f} s", end_s);
  plot::save(pictures::strip_figure(arguments.path, look, strip, end_s), arguments.drawing);
}

/// Simulates prior draws: as many as requested, or as many as fit into the time.
user_scene::PriorDraws draw_prior(const user_scene::UserScene& world, std::uint64_t wanted) {
  const base::SteadyClock clock;
  const double start_s = clock.now_s();
  double told_s = start_s;
  return user_scene::prior_draws(world, wanted > 0 ? wanted : k_draws_max, [&](std::uint64_t done) {
    const double now_s = clock.now_s();
    if (wanted == 0) return now_s - start_s < k_draws_s;
    if (now_s - told_s >= k_progress_s) {
      told_s = now_s;
      const double left_s =
          (now_s - start_s) * static_cast<double>(wanted - done) / static_cast<double>(done);
      fmt::print(stderr, "{} of {} prior draws, {:.0f} s left\n", done, wanted, left_s);
    }
    return true;
  });
}

json::Value report_json(const user_scene::SceneReport& report) {
  json::Value json{{"warnings", report.warnings}, {"run", nullptr}};
  if (report.run) {
    json["run"] = {{"end", name_of(report.run->end)}, {"end_s", report.run->end_s}};
    if (report.run->error) json["run"]["error"] = report.run->error->message;
  }
  if (report.draws)
    json["prior_draws"] = {{"count", report.draws->count},
                           {"overlap", report.draws->overlap},
                           {"failed", report.draws->failed},
                           {"not_settled", report.draws->not_settled},
                           {"met", report.draws->met}};
  for (const user_scene::Table& table : tables_of(report)) {
    json::Value rows = json::Value::array();
    for (const auto& cells : table.rows) {
      json::Value row = json::Value::object();
      for (std::size_t i = 0; i < cells.size(); ++i)
        row[table.columns[i]] =
            std::visit([](const auto& cell) { return json::Value(cell); }, cells[i]);
      rows.push_back(std::move(row));
    }
    (table.of_run ? json["run"] : json)[table.key] = std::move(rows);
  }
  return json;
}

base::ExitCode exit_code(const user_scene::SceneReport& report) {
  // If draws can be simulated, the described scene itself needn't.
  if (report.draws && report.draws->count > report.draws->overlap + report.draws->failed)
    return base::ExitCode::ok;
  if (!report.run) return base::ExitCode::bad_request;
  if (!report.run->error) return base::ExitCode::ok;
  return physics::is_failure(report.run->error->kind) ? base::ExitCode::simulation_failed
                                                      : base::ExitCode::bad_request;
}

int check(const SceneArguments& arguments) {
  const std::optional<Parameters> parameters = read_scene(arguments);
  if (!parameters) return static_cast<int>(base::ExitCode::bad_request);
  const user_scene::UserScene world(*parameters);
  user_scene::SceneReport report = user_scene::check(parameters->scene, *parameters->built);
  if (!parameters->uncertain.empty() || world.has_noise())
    user_scene::add_draws(world, draw_prior(world, arguments.draws), report);
  if (!arguments.drawing.empty()) {
    terminal::refuse_same_file(arguments.path, arguments.drawing);
    if (exit_code(report) == base::ExitCode::ok) {
      draw(world, report, arguments);
    } else {
      terminal::complain(
          fmt::format("{} isn't written, because the scene can't be simulated", arguments.drawing));
    }
  }
  return terminal::with_results([&] {
    if (arguments.json) {
      fmt::print("{}\n", report_json(report).dump(2));
    } else {
      fmt::print("{}", user_scene::report_text(report));
    }
    return static_cast<int>(exit_code(report));
  });
}

}  // namespace

void add_scene_commands(CLI::App& app, SceneArguments& arguments, Action& action) {
  CLI::App* scene = app.add_subcommand("scene", "Check a scene of your own");
  scene->require_subcommand(1);
  CLI::App* command =
      scene->add_subcommand("check", "Say what a scene contains, and simulate it once");
  command
      ->add_option("request", arguments.path,
                   "Request of world \"scene\" (TOML). -: standard input")
      ->required()
      ->type_name("SCENE.toml");
  add_sets_option(*command, arguments.sets);
  command
      ->add_option("--draw", arguments.drawing,
                   "Picture to write: nine prior draws, or the simulation at eight times")
      ->type_name("FILE.svg|FILE.png")
      ->check([](const std::string& name) {
        return name.empty() ? "expected a file name, found an empty one" : "";
      });
  command
      ->add_option("--draws", arguments.draws,
                   "Number of prior draws to simulate; default: as many as fit into 0.3 s")
      ->check(CLI::Range(std::uint64_t{1}, std::uint64_t{1'000'000}));
  command->add_flag("--json", arguments.json, "Print JSON, in SI units");
  command->footer(
      "Lists bodies, static things, all overlaps at the start, and what each body does until\n"
      "end_s, and what happens in draws from the prior. `sleight keys scene` lists the keys of a "
      "scene.\n\n"
      "Exit codes: 0 the scene can be simulated; 3 it can't, because of its request or of "
      "overlaps;\n"
      "8 the simulator failed.\n\n"
      "Examples:\n  sleight scene check tray.toml\n"
      "  sleight scene check tray.toml --draw tray.svg --draws 1000\n"
      "  sleight scene check tray.toml --set world.end_s=3 --json");
  command->callback([&] { action = [&] { return check(arguments); }; });
}

}  // namespace sleight::programs
