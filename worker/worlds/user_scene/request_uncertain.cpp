#include "worker/worlds/user_scene/request_uncertain.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <numeric>
#include <optional>
#include <utility>

#include "common/request/text.h"
#include "worker/worlds/user_scene/request.h"

namespace sleight::worlds::user_scene {
namespace {

using request::Binder;

constexpr std::size_t k_uncertain_max = 1000;
constexpr std::size_t k_choices_max = 300;

std::vector<request::Named<Quantity>> quantity_names() {
  std::vector<request::Named<Quantity>> names;
  for (const QuantityKind& kind : all_quantities())
    names.push_back({kind.key, kind.quantity});
  return names;
}

/// The keys of one [[world.uncertain]].
struct UncertainKeys {
  std::optional<std::string> name{};
  std::vector<std::string> bodies{};
  std::optional<std::string> material{};
  std::vector<double> normal_sd{};
  std::vector<double> within{};
  std::vector<double> choices{};
  std::vector<double> shares{};
  std::optional<double> probability{};
};

void bind_keys(Binder& table, UncertainKeys& keys, Uncertain& one) {
  table.optional_text("name", keys.name,
                      a_name("name in archives; default: the body's name and the quantity"));
  keys.bodies = ObjectNames::bind(table);
  table.optional_text("material", keys.material,
                      a_name("name of a [[world.material]], instead of a body"));
  const std::vector<request::Named<Quantity>> names = quantity_names();
  table.required_choice<Quantity>(
      "quantity", one.quantity, names,
      "what is uncertain; a turn rotates the body about the world's axes, and an orientation is "
      "uniform among all rotations");
  const auto numbers = [&](const char* key, std::vector<double>& values, const char* help) {
    table.numbers(key, values, {.count_min = 1, .count_max = 3},
                  {.minimum = 0, .maximum = 1e6, .help = help});
  };
  numbers("normal_sd", keys.normal_sd,
          "standard deviation of each component around the described value; 0: fixed");
  numbers("within", keys.within,
          "greatest difference from the described value; alone: uniform; with normal_sd: a "
          "truncated normal");
  table.numbers("choices", keys.choices, {.count_min = 1, .count_max = k_choices_max},
                {.minimum = -1e6,
                 .maximum = 1e6,
                 .help = "values to choose from; each vector takes three numbers"});
  table.numbers("shares", keys.shares, {.count_min = 1, .count_max = k_choices_max},
                {.minimum = 0, .maximum = 1e6, .help = "shares of the choices; default: equal"});
  table.optional_number("probability", keys.probability,
                        {.minimum = 0,
                         .above_minimum = true,
                         .maximum = 1,
                         .help = "probability that the body takes part (presence)"});
  table.boolean("shared", one.shared, "whether one draw serves all bodies instead of one for each");
}

/// Reads the components' distribution. Returns whether all is well.
bool read_components(Binder& table, const UncertainKeys& keys, const QuantityKind& kind,
                     Uncertain& one) {
  bool any = false;
  for (const auto& [key, given, values] : {std::tuple{"normal_sd", &keys.normal_sd, &one.sd},
                                           std::tuple{"within", &keys.within, &one.within}}) {
    if (given->empty()) continue;
    if (given->size() != kind.width) {
      table.error(key,
                  fmt::format("expected {} for {}, found {}",
                              kind.width == 1 ? "1 number" : "3 numbers", kind.key, given->size()));
      return false;
    }
    for (std::size_t i = 0; i < kind.width; ++i)
      (*values)[i] = kind.scale * (*given)[i];
    any = any || std::ranges::any_of(*values, [](double value) { return value > 0; });
  }
  if (any) return true;
  const bool is_given = !keys.normal_sd.empty() || !keys.within.empty();
  table.error(keys.normal_sd.empty() && is_given ? "within" : "normal_sd",
              fmt::format("{}; give normal_sd, within or choices, so that {} is uncertain",
                          is_given ? "must not be all 0" : "missing", kind.key));
  return false;
}

bool read_choices(Binder& table, const UncertainKeys& keys, const QuantityKind& kind,
                  Uncertain& one) {
  const std::size_t count = keys.choices.size() / kind.width;
  if (keys.choices.size() % kind.width != 0 || !keys.normal_sd.empty() || !keys.within.empty()) {
    table.error("choices", keys.choices.size() % kind.width != 0
                               ? fmt::format("expected 3 numbers for each choice of {}, found {} "
                                             "numbers",
                                             kind.key, keys.choices.size())
                               : "set either choices, or normal_sd and within");
    return false;
  }
  for (std::size_t i = 0; i < count; ++i) {
    std::vector<double>& choice = one.choices.emplace_back();
    for (std::size_t j = 0; j < kind.width; ++j) {
      choice.push_back(kind.scale * keys.choices[i * kind.width + j]);
      if (choice.back() >= kind.minimum && choice.back() <= kind.maximum) continue;
      table.error("choices", fmt::format("expected numbers from {:.6g} to {:.6g} for {}, found {}",
                                         kind.minimum / kind.scale, kind.maximum / kind.scale,
                                         kind.key, keys.choices[i * kind.width + j]));
      return false;
    }
  }
  one.shares = keys.shares.empty() ? std::vector<double>(count, 1) : keys.shares;
  const double sum = std::accumulate(one.shares.begin(), one.shares.end(), 0.0);
  if (one.shares.size() != count || !(sum > 0)) {
    table.error("shares", one.shares.size() == count
                              ? "must not be all 0"
                              : fmt::format("expected {} shares, one for each choice, found {}",
                                            count, one.shares.size()));
    return false;
  }
  for (double& share : one.shares)
    share /= sum;
  return true;
}

/// Reports keys that a quantity doesn't have. Returns whether all is well.
bool check_keys(Binder& table, const QuantityKind& kind) {
  const bool is_presence = kind.quantity == Quantity::presence;
  const bool has_numbers = !is_presence && kind.quantity != Quantity::orientation;
  for (const auto& [key, has] :
       {std::pair{"normal_sd", has_numbers}, std::pair{"within", has_numbers},
        std::pair{"choices", has_numbers}, std::pair{"probability", is_presence},
        std::pair{"shares", table.given("choices")}}) {
    if (has || !table.given(key)) continue;
    table.error(key, has_numbers && std::string_view(key) == "shares"
                         ? "belongs to choices, which are missing"
                         : fmt::format("{} has no such key; remove it", kind.key));
    return false;
  }
  if (is_presence && !table.given("probability"))
    table.error("probability", "missing; presence needs it");
  return table.is_sound();
}

bool read_distribution(Binder& table, const UncertainKeys& keys, Uncertain& one) {
  const QuantityKind& kind = kind_of(one.quantity);
  if (!check_keys(table, kind)) return false;
  one.sd.assign(kind.width, 0);
  one.within.assign(kind.width, 0);
  one.probability = keys.probability.value_or(1);
  if (one.quantity == Quantity::presence || one.quantity == Quantity::orientation) return true;
  return keys.choices.empty() ? read_components(table, keys, kind, one)
                              : read_choices(table, keys, kind, one);
}

/// Reports bodies that don't have the quantity.
void check_bodies(Binder& table, const Uncertain& one, const ObjectNames& objects) {
  for (const std::uint32_t target : one.targets) {
    const BodyDescription& body = objects.described(target);
    const std::string name = request::toml_string(objects.object(target).name);
    const auto needs = [&](Quantity quantity, ShapeKind shape) {
      if (one.quantity != quantity || body.sizes.kind == shape) return;
      table.error("quantity", fmt::format("is for a {}, but {} is a {}", name_of(shape), name,
                                          name_of(body.sizes.kind)));
    };
    needs(Quantity::radius, ShapeKind::sphere);
    needs(Quantity::size, ShapeKind::box);
    if (!table.is_sound()) return;
    if (!body.rests) continue;
    if (one.quantity == Quantity::start || one.quantity == Quantity::presence)
      table.error("quantity", fmt::format("{} starts at rest, so it is always there", name));
    if (one.quantity == Quantity::velocity || one.quantity == Quantity::spin)
      table.error("quantity", fmt::format("{} starts at rest, so its speed is 0", name));
    if (!table.is_sound()) return;
  }
}

}  // namespace

std::vector<std::string> ObjectNames::bind(Binder& table) {
  std::optional<std::string> body;
  table.optional_text("body", body, a_name("name of a body; a body with copies: all copies"));
  std::vector<std::string> bodies;
  table.texts("bodies", bodies, {.count_min = 1, .count_max = k_objects_max},
              a_name("names of several bodies"));
  if (body && !bodies.empty()) table.error("bodies", "set either body or bodies, not both");
  if (body) bodies = {*body};
  return bodies;
}

std::vector<std::uint32_t> ObjectNames::find(Binder& table, std::string_view key,
                                             const std::string& name, bool must_move) const {
  std::vector<std::uint32_t> found;
  std::vector<std::string> names;
  for (std::uint32_t i = 0; i < built_.objects.size(); ++i) {
    const Object& object = built_.objects[i];
    const std::string& base = scene_.bodies[object.description].name;
    if (object.name == name || base == name) found.push_back(i);
    if (names.empty() || names.back() != base) names.push_back(base);
    if (object.name != base) names.push_back(object.name);
  }
  if (found.empty()) {
    table.error(key, unknown("body", name, names));
  } else if (must_move && found.front() >= built_.moving) {
    table.error(key, fmt::format("{} never moves", request::toml_string(name)));
    return {};
  }
  return found;
}

std::vector<std::uint32_t> ObjectNames::find_all(Binder& table,
                                                 const std::vector<std::string>& names) const {
  std::vector<std::uint32_t> all;
  for (const std::string& name : names) {
    const char* key = table.given("body") ? "body" : "bodies";
    for (const std::uint32_t object : find(table, key, name, true)) {
      if (std::ranges::count(all, object) > 0) {
        table.error(key, fmt::format("{} is named twice",
                                     request::toml_string(built_.objects[object].name)));
        return {};
      }
      all.push_back(object);
    }
  }
  return all;
}

void bind_uncertain(Binder& world, Parameters& parameters, const ObjectNames* objects,
                    const NameList& materials) {
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
        if (keys.material.has_value() != kind.of_material ||
            keys.bodies.empty() != kind.of_material)
          return table.error("quantity", kind.of_material
                                             ? "needs the key material, and neither body nor bodies"
                                             : "needs the key body or bodies, and no material");
        if (!read_distribution(table, keys, one)) return;
        if (kind.of_material) {
          one.targets = {materials.find(table, "material", *keys.material)};
        } else if (objects != nullptr) {
          one.targets = objects->find_all(table, keys.bodies);
          if (table.is_sound()) check_bodies(table, one, *objects);
        }
        const std::string& of = kind.of_material ? *keys.material : keys.bodies.front();
        one.name = keys.name.value_or(fmt::format("{} {}", of, kind.key));
        if (keys.name) names.add(table, "name", *keys.name);
        // A turn and an orientation change the same thing.
        const Quantity same = one.quantity == Quantity::orientation ? Quantity::turn : one.quantity;
        for (const std::uint32_t target : one.targets) {
          const auto [at, is_new] = lines.try_emplace({same, target}, table.line());
          if (is_new) continue;
          table.error("quantity",
                      fmt::format("is already uncertain for {} (see line {})",
                                  request::toml_string(kind.of_material
                                                           ? parameters.scene.materials[target].name
                                                           : objects->object(target).name),
                                  at->second));
          return;
        }
      });
}

}  // namespace sleight::worlds::user_scene
