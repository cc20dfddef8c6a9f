#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <numeric>
#include <optional>
#include <utility>

#include "common/request/text.h"
#include "worker/worlds/user_scene/request.h"
#include "worker/worlds/user_scene/request_parts.h"

namespace sleight::worlds::user_scene {
namespace {

using request::Binder;

constexpr std::size_t k_uncertain_max = 1000;
constexpr std::size_t k_choices_max = 300;

/// The keys of one [[world.uncertain]] that have no member in Uncertain.
struct UncertainKeys {
  std::vector<std::string> bodies{};
  std::string material{};
  std::vector<double> choices{};
};

void bind_keys(Binder& table, UncertainKeys& keys, Uncertain& one) {
  table.optional_text("name", one.name,
                      a_name("name in archives; default: the body's name and the quantity"));
  keys.bodies = bind_body_names(table);
  table.optional_text("material", keys.material,
                      a_name("name of a [[world.material]], instead of a body"));
  std::vector<request::Named<Quantity>> names;
  for (const QuantityKind& kind : all_quantities())
    names.push_back({kind.key, kind.quantity});
  table.required_choice<Quantity>(
      "quantity", one.quantity, names,
      "what is uncertain; a turn rotates the body about the world's axes, and an orientation is "
      "uniform among all rotations");
  const auto numbers = [&](const char* key, std::vector<double>& values, std::size_t count_max,
                           double minimum, const char* help) {
    table.numbers(key, values, {.count_min = 1, .count_max = count_max},
                  {.minimum = minimum, .maximum = 1e6, .help = help});
  };
  numbers("normal_sd", one.sd, 3, 0,
          "standard deviation of each component around the described value; 0: fixed");
  numbers("within", one.within, 3, 0,
          "greatest difference from the described value; alone: uniform; with normal_sd: a "
          "truncated normal");
  numbers("choices", keys.choices, k_choices_max, -1e6,
          "values to choose from; each vector takes three numbers");
  numbers("shares", one.shares, k_choices_max, 0, "shares of the choices; default: equal");
  table.optional_number("probability", one.probability,
                        {.minimum = 0,
                         .above_minimum = true,
                         .maximum = 1,
                         .help = "probability that the body takes part (presence)"});
  table.boolean("shared", one.shared, "whether one draw serves all bodies instead of one for each");
}

/// Reads the components' distribution.
void read_components(Binder& table, const QuantityKind& kind, Uncertain& one) {
  bool any = false;
  for (const auto& [key, values] :
       {std::pair{"normal_sd", &one.sd}, std::pair{"within", &one.within}}) {
    if (!values->empty() && values->size() != kind.width)
      return table.error(
          key, fmt::format("expected {} for {}, found {}",
                           kind.width == 1 ? "1 number" : "3 numbers", kind.key, values->size()));
    for (double& value : *values)
      value *= kind.scale;
    any = any || std::ranges::any_of(*values, [](double value) { return value > 0; });
  }
  if (any) return;
  const bool is_given = !one.sd.empty() || !one.within.empty();
  table.error(one.sd.empty() && is_given ? "within" : "normal_sd",
              fmt::format("{}; give normal_sd, within or choices, so that {} is uncertain",
                          is_given ? "must not be all 0" : "missing", kind.key));
}

void read_choices(Binder& table, const std::vector<double>& given, const QuantityKind& kind,
                  Uncertain& one) {
  if (given.size() % kind.width != 0)
    return table.error("choices",
                       fmt::format("expected 3 numbers for each choice of {}, found {} numbers",
                                   kind.key, given.size()));
  if (!one.sd.empty() || !one.within.empty())
    return table.error("choices", "set either choices, or normal_sd and within");
  for (std::size_t i = 0; i < given.size(); ++i) {
    if (i % kind.width == 0) one.choices.emplace_back();
    const double value = one.choices.back().emplace_back(kind.scale * given[i]);
    if (value < kind.minimum || value > kind.maximum)
      return table.error("choices", fmt::format("expected numbers from {:.6g} to {:.6g} for {}, "
                                                "found {}",
                                                kind.minimum / kind.scale,
                                                kind.maximum / kind.scale, kind.key, given[i]));
  }
  const std::size_t count = one.choices.size();
  if (one.shares.empty()) one.shares.assign(count, 1);
  if (one.shares.size() != count)
    return table.error("shares", fmt::format("expected {} shares, one for each choice, found {}",
                                             count, one.shares.size()));
  const double sum = std::accumulate(one.shares.begin(), one.shares.end(), 0.0);
  if (!(sum > 0)) return table.error("shares", "must not be all 0");
  for (double& share : one.shares)
    share /= sum;
}

void read_distribution(Binder& table, const UncertainKeys& keys, const QuantityKind& kind,
                       Uncertain& one) {
  const bool is_presence = kind.quantity == Quantity::presence;
  const bool has_numbers = !is_presence && kind.quantity != Quantity::orientation;
  for (const auto& [key, has] :
       {std::pair{"normal_sd", has_numbers}, std::pair{"within", has_numbers},
        std::pair{"choices", has_numbers}, std::pair{"probability", is_presence},
        std::pair{"shares", has_numbers}}) {
    if (!has && table.given(key))
      return table.error(key, fmt::format("{} has no such key; remove it", kind.key));
  }
  if (!keys.choices.empty()) {
    read_choices(table, keys.choices, kind, one);
  } else if (!one.shares.empty()) {
    table.error("shares", "belongs to choices, which are missing");
  } else if (has_numbers) {
    read_components(table, kind, one);
  } else if (is_presence && !table.given("probability")) {
    table.error("probability", "missing; presence needs it");
  }
  one.sd.resize(kind.width);
  one.within.resize(kind.width);
}

/// Reports bodies that don't have the quantity.
void check_bodies(Binder& table, const Uncertain& one, const Parameters& parameters) {
  for (const std::uint32_t target : one.targets) {
    const BodyDescription& body = parameters.described(target);
    const std::string name = request::toml_string(parameters.built->objects[target].name);
    const auto needs = [&](Quantity quantity, ShapeKind shape) {
      if (one.quantity == quantity && body.sizes.kind != shape)
        table.error("quantity", fmt::format("is for a {}, but {} is a {}", name_of(shape), name,
                                            name_of(body.sizes.kind)));
    };
    needs(Quantity::radius, ShapeKind::sphere);
    needs(Quantity::size, ShapeKind::box);
    if (body.rests && (one.quantity == Quantity::start || one.quantity == Quantity::presence))
      table.error("quantity", fmt::format("{} starts at rest, so it is always there", name));
    if (body.rests && (one.quantity == Quantity::velocity || one.quantity == Quantity::spin))
      table.error("quantity", fmt::format("{} starts at rest, so its speed is 0", name));
    if (!table.is_sound()) return;
  }
}

}  // namespace

std::vector<std::string> bind_body_names(Binder& table) {
  std::string body;
  const bool has_body =
      table.optional_text("body", body, a_name("name of a body; a body with copies: all copies"));
  std::vector<std::string> bodies;
  table.texts("bodies", bodies, {.count_min = 1, .count_max = k_objects_max},
              a_name("names of several bodies"));
  if (has_body && !bodies.empty()) table.error("bodies", "set either body or bodies, not both");
  if (has_body) return {body};
  return bodies;
}

std::vector<std::uint32_t> find_objects(Binder& table, std::string_view key,
                                        const std::string& name, const Parameters& parameters) {
  std::vector<std::uint32_t> found;
  std::vector<std::string> names;
  for (std::uint32_t i = 0; i < parameters.built->objects.size(); ++i) {
    const std::string& own = parameters.built->objects[i].name;
    const std::string& base = parameters.described(i).name;
    if (own == name || base == name) found.push_back(i);
    if (names.empty() || names.back() != base) names.push_back(base);
    if (own != base) names.push_back(own);
  }
  if (found.empty()) table.error(key, unknown("body", name, names));
  return found;
}

std::vector<std::uint32_t> find_moving(Binder& table, const std::vector<std::string>& names,
                                       const Parameters& parameters) {
  std::vector<std::uint32_t> all;
  const char* const key = table.given("body") ? "body" : "bodies";
  for (const std::string& name : names) {
    for (const std::uint32_t object : find_objects(table, key, name, parameters)) {
      const std::string& own = parameters.built->objects[object].name;
      const bool moves = object < parameters.built->moving;
      if (moves && std::ranges::count(all, object) == 0) {
        all.push_back(object);
        continue;
      }
      table.error(key, moves ? fmt::format("{} is named twice", request::toml_string(own))
                             : fmt::format("{} never moves", request::toml_string(name)));
      return {};
    }
  }
  return all;
}

void bind_uncertain(Binder& world, const NameList& materials, Parameters& parameters) {
  std::map<std::pair<Quantity, std::uint32_t>, std::uint32_t> lines;
  NameList names("quantity");
  world.tables<Uncertain>(
      "uncertain", parameters.uncertain,
      {.count_max = k_uncertain_max, .help = "what is uncertain: differs from take to take"},
      [&](Binder& table, Uncertain& one) {
        UncertainKeys keys;
        bind_keys(table, keys, one);
        if (table.line() == 0 || !table.is_sound()) return;
        const QuantityKind& kind = kind_of(one.quantity);
        if (table.given("material") != kind.of_material || keys.bodies.empty() != kind.of_material)
          return table.error("quantity", kind.of_material
                                             ? "needs the key material, and neither body nor bodies"
                                             : "needs the key body or bodies, and no material");
        read_distribution(table, keys, kind, one);
        if (!table.is_sound()) return;
        if (kind.of_material) {
          one.targets = {materials.find(table, "material", keys.material)};
        } else if (parameters.built) {
          one.targets = find_moving(table, keys.bodies, parameters);
          if (table.is_sound()) check_bodies(table, one, parameters);
        }
        if (table.given("name")) {
          names.add(table, "name", one.name);
        } else {
          one.name = fmt::format("{} {}", kind.of_material ? keys.material : keys.bodies.front(),
                                 kind.key);
        }
        // A turn and an orientation change the same thing.
        const Quantity same = one.quantity == Quantity::orientation ? Quantity::turn : one.quantity;
        for (const std::uint32_t target : one.targets) {
          const auto [at, is_new] = lines.try_emplace({same, target}, table.line());
          if (is_new) continue;
          const std::string& name = kind.of_material ? parameters.scene.materials[target].name
                                                     : parameters.built->objects[target].name;
          return table.error("quantity", fmt::format("is already uncertain for {} (see line {})",
                                                     request::toml_string(name), at->second));
        }
      });
}

}  // namespace sleight::worlds::user_scene
