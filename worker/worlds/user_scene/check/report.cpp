#include "worker/worlds/user_scene/check/check.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <string_view>
#include <utility>

#include "common/request/text.h"
#include "worker/worlds/user_scene/request.h"

namespace sleight::worlds::user_scene {
namespace {

using Row = std::vector<Cell>;

Cell numbers(const Vec3& v) {
  return std::vector{v.x(), v.y(), v.z()};
}

void add_objects(const SceneReport& report, Table& table) {
  for (std::uint32_t object = 0; object < report.built.objects.size(); ++object) {
    const Object& one = report.built.objects[object];
    const BodyDescription& body = report.description.bodies[one.description];
    Row row{one.name, std::string(name_of(body.sizes.kind)),
            report.description.materials[body.material].name};
    row.resize(table.columns.size());
    if (object < report.built.moving) {
      const physics::Inertia& inertia = report.built.inertia(object);
      row[4] = inertia.mass_kg;
      row[5] = numbers(one.frame.position_m);
      // About axes through the centre of mass, parallel to those of the shape's frame.
      row[6] = numbers(math::matrix_of(one.frame.orientation).cwiseAbs2() * inertia.principal_kgm2);
    } else {
      row[3] = numbers(one.place.position_m);
    }
    table.rows.push_back(std::move(row));
  }
}

/// Lists all pairs of materials of which one belongs to a moving body.
void add_contacts(const SceneDescription& description, Table& table) {
  std::set<std::pair<std::uint32_t, std::uint32_t>> pairs;
  for (const BodyDescription& a : description.bodies) {
    for (const BodyDescription& b : description.bodies) {
      if (!(a.is_static && b.is_static)) pairs.insert(std::minmax(a.material, b.material));
    }
  }
  const physics::ContactTable laws = contact_table(description.materials, description.pairs);
  for (const auto& [a, b] : pairs) {
    const physics::SurfaceLaw& law =
        laws.between({static_cast<std::uint8_t>(a)}, {static_cast<std::uint8_t>(b)});
    table.rows.push_back({description.materials[a].name, description.materials[b].name,
                          law.restitution, law.friction, law.rolling_friction});
  }
}

void add_run(const SceneReport& report, Table& bodies, Table& hits) {
  constexpr std::array k_ends{"waits", "moves", "rests", "left"};
  for (std::uint32_t body = 0; body < report.run->bodies.size(); ++body) {
    const BodyOutcome& one = report.run->bodies[body];
    Row row{report.built.objects[body].name, k_ends.at(static_cast<std::size_t>(one.end))};
    row.resize(bodies.columns.size());
    if (one.end == BodyEnd::rests) row[2] = one.rests_since_s;
    if (one.end != BodyEnd::waits) {
      row[3] = one.speed_mps;
      row[4] = numbers(one.place.position_m);
    }
    row[5] = one.hits;
    bodies.rows.push_back(std::move(row));
  }
  for (const Hits& one : report.run->hits)
    hits.rows.push_back({report.built.objects[one.a].name, report.built.objects[one.b].name,
                         one.count, one.first_s});
}

void add_prior_draws(const PriorDraws& draws, const UserScene& world, Table& uncertain,
                     Table& constraints) {
  const std::vector<std::string> names = world.quantities().value_names();
  for (std::size_t i = 0; i < names.size(); ++i) {
    const auto& [least, mean, greatest] = draws.values[i];
    uncertain.rows.push_back({names[i], least, mean, greatest});
  }
  for (std::size_t i = 0; i < draws.least_distances.size(); ++i) {
    const Constraint& one = world.parameters().constraints[i];
    const DistanceUnit unit = unit_of(one);
    const double least = draws.least_distances[i] / unit.scale;
    constraints.rows.push_back({one.name, draws.constraint_met[i],
                                std::isfinite(least) ? Cell(least) : Cell(nullptr),
                                std::string(unit.name)});
  }
}

// ---- text ---------------------------------------------------------------------------------------

/// How the text shows numbers whose key has this end.
struct Unit {
  std::string_view end;
  std::string_view name;
  double factor;
  const char* format;
};
constexpr std::array<Unit, 7> k_units{{{"_kgm2", " (g mm^2)", 1e9, "{:.4g}"},
                                       {"_kg", " (g)", 1e3, "{:.6g}"},
                                       {"_m3", " (cm^3)", 1e6, "{:.4g}"},
                                       {"_mps", " (m/s)", 1, "{:.3g}"},
                                       {"_m", " (mm)", 1e3, "{:.2f}"},
                                       {"_s", " (s)", 1, "{:.3f}"},
                                       {"", "", 1, "{:.3g}"}}};

const Unit& unit_of(std::string_view key) {
  return *std::ranges::find_if(k_units, [&](const Unit& unit) { return key.ends_with(unit.end); });
}

std::string text_of(std::string_view key, const Cell& cell) {
  if (const auto* text = std::get_if<std::string>(&cell)) return *text;
  if (const auto* count = std::get_if<std::uint64_t>(&cell)) return fmt::format("{}", *count);
  std::vector<double> values;
  if (const auto* value = std::get_if<double>(&cell)) values = {*value};
  if (const auto* several = std::get_if<std::vector<double>>(&cell)) values = *several;
  const Unit& unit = unit_of(key);
  std::string text;
  for (double value : values) {
    value *= unit.factor;
    if (unit.end == "_m" && std::fabs(value) < 0.005) value = 0;  // not "-0.00"
    if (!text.empty()) text += ' ';
    text += fmt::format(fmt::runtime(unit.format), value);
  }
  return text;
}

/// Cuts a long list.
std::string list(const std::string& title, const std::vector<std::string>& lines) {
  constexpr std::size_t k_lines_max = 20;
  if (lines.empty()) return "";
  std::string text = title + "\n";
  const std::size_t shown = std::min(lines.size(), k_lines_max);
  for (std::size_t i = 0; i < shown; ++i)
    text += "  " + lines[i].substr(0, lines[i].find_last_not_of(' ') + 1) + "\n";
  return text +
         (shown < lines.size() ? fmt::format("  ... and {} more\n\n", lines.size() - shown) : "\n");
}

/// Returns aligned columns; texts are aligned to the left. Consecutive rows that differ only in
/// their names become one row, "die 1 to die 5".
std::string text_of(const Table& table) {
  if (table.rows.empty() || table.title.empty()) return "";
  std::vector<std::vector<std::string>> lines(1);
  for (const std::string& key : table.columns) {
    const Unit& unit = unit_of(key);
    std::string head = key.substr(0, key.size() - unit.end.size());
    std::ranges::replace(head, '_', ' ');
    lines[0].push_back(head + std::string(unit.name));
  }
  std::string first_name;
  for (const Row& row : table.rows) {
    std::vector<std::string> line;
    for (std::size_t c = 0; c < row.size(); ++c)
      line.push_back(text_of(table.columns[c], row[c]));
    if (std::equal(line.begin() + 1, line.end(), lines.back().begin() + 1)) {
      lines.back()[0] = first_name + " to " + line[0];
    } else {
      first_name = line[0];
      lines.push_back(std::move(line));
    }
  }
  std::vector<std::string> padded(lines.size());
  for (std::size_t c = 0; c < table.columns.size(); ++c) {
    std::size_t width = 0;
    for (const auto& line : lines)
      width = std::max(width, request::character_count(line[c]));
    const bool is_text = std::holds_alternative<std::string>(table.rows[0][c]);
    for (std::size_t i = 0; i < lines.size(); ++i) {
      const std::string fill(width - request::character_count(lines[i][c]), ' ');
      padded[i] += (c == 0 ? "" : "  ") + (is_text ? lines[i][c] + fill : fill + lines[i][c]);
    }
  }
  return list(table.title, padded);
}

}  // namespace

const char* name_of(RunEnd end) {
  constexpr std::array k_names{"every body rests or has left", "time is over", "too many events",
                               "failed"};
  return k_names.at(static_cast<std::size_t>(end));
}

std::vector<Table> tables_of(const SceneReport& report) {
  const auto name = [&](std::uint32_t object) { return report.built.objects[object].name; };
  std::vector<Table> tables{
      {"Objects",
       "objects",
       false,
       {"name", "shape", "material", "static_at_m", "mass_kg", "centre_of_mass_m", "moments_kgm2"}},
      {"Contacts",
       "contacts",
       false,
       {"material", "with", "restitution", "friction", "rolling_friction"}},
      {"Meshes", "meshes", false, {"name", "surface", "boundary_edges", "volume_m3"}},
      {"", "overlaps", false, {"a", "b", "depth_m", "a_is_inside"}},
      {"Run", "bodies", true, {"name", "end", "rests_since_s", "speed_mps", "place_m", "hits"}},
      {"Hits", "hits", true, {"a", "b", "count", "first_s"}},
      {"Uncertain", "uncertain", false, {"name", "least", "mean", "greatest"}},
      {"Constraints", "constraints", false, {"name", "met", "least_distance", "unit"}}};
  add_objects(report, tables[0]);
  add_contacts(report.description, tables[1]);
  for (const Closedness& mesh : report.meshes) {
    const char* closed = mesh.volume_m3 < 0 ? "inside out" : "closed";
    tables[2].rows.push_back({name(mesh.object), mesh.boundary_edges > 0 ? "open" : closed,
                              mesh.boundary_edges, mesh.volume_m3});
  }
  for (const Overlap& one : report.overlaps)
    tables[3].rows.push_back({name(one.a), name(one.b), one.depth_m, one.inside});
  if (report.run) add_run(report, tables[4], tables[5]);
  if (report.draws) add_prior_draws(*report.draws, *report.world, tables[6], tables[7]);
  return tables;
}

std::string report_text(const SceneReport& report) {
  const Vec3& g = report.description.gravity_mps2;
  std::string text = list("Attention", report.warnings);
  text += fmt::format(
      "Scene: moving bodies: {}, static objects: {}, gravity {:.4g} {:.4g} {:.4g} m/s^2\n",
      report.built.moving, report.built.objects.size() - report.built.moving, g.x(), g.y(), g.z());
  const physics::SlowContacts& slow = report.built.scene.slow;
  text += fmt::format(
      "Slow contacts: bodies bounce at {:.3g} m/s or faster, and rest after {:.3g} s below {:.3g} "
      "m/s\n",
      slow.separation_speed_mps, slow.rest_time_s, slow.rest_speed_mps);
  const physics::ContactNoise& noise = report.description.noise;
  if (report.description.has_noise())
    text +=
        fmt::format("Contact noise: above {:.3g} m/s; tilt {:.3g} degrees; restitution {:.3g}\n",
                    noise.above_mps, noise.tilt_sd_rad / k_rad_per_deg, noise.restitution_sd);
  text += report.run ? fmt::format("Run: {} after {:.3f} s\n\n", name_of(report.run->end),
                                   report.run->end_s)
                     : "Run: none, because objects overlap at the start\n\n";
  if (report.draws)
    text += fmt::format("Prior draws: {}; all constraints are met in {}\n\n", report.draws->count,
                        report.draws->met);
  for (const Table& table : tables_of(report))
    text += text_of(table);
  return text;
}

}  // namespace sleight::worlds::user_scene
