#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "common/request/common_sections.h"
#include "common/request/direction_request.h"
#include "common/request/document.h"
#include "common/request/nearest.h"
#include "common/request/sets.h"
#include "common/request/text.h"

namespace sleight::request {
namespace {

constexpr std::size_t k_name_characters_max = 60;

std::string shown(std::string_view name) {
  return printable(name, k_name_characters_max);
}

std::vector<std::string> names_of(const Binder& section) {
  std::vector<std::string> names;
  for (const BoundKey& bound : section.keys())
    names.push_back(bound.spec.key);
  return names;
}

class UnknownKeys {
 public:
  UnknownKeys(const SectionBinders& sections, Diagnostics& diagnostics)
      : sections_(sections.all()), diagnostics_(diagnostics) {
    for (const Binder* section : sections_) {
      section_names_.push_back(section->section_name());
      keys_.push_back(names_of(*section));
    }
  }

  void section(const Section& section) {
    diagnostics_.add(section.place, fmt::format("unknown section [{}]; {}", shown(section.name),
                                                meant_section(section.name)));
  }

  /// `section_known`: whether all possible keys of the section are declared.
  void key(const Entry& entry, const std::string& section, bool section_known) {
    const std::size_t index = static_cast<std::size_t>(
        std::find(section_names_.begin(), section_names_.end(), section) - section_names_.begin());
    const std::vector<std::string>& known = keys_[index];
    if (std::find(known.begin(), known.end(), entry.key) != known.end()) return;
    if (is_command_line_option(entry.key)) return command_line_option(entry);
    if (!section_known) return;
    diagnostics_.add(entry.place, fmt::format("unknown key '{}' in [{}]; {}", shown(entry.key),
                                              section, meant_key(entry, known)));
  }

  /// Reports the unknown keys of a section's or table's tables.
  void tables(const Section& section, const BoundSection& bound) {
    for (const BoundTables& tables : bound.tables) {
      std::vector<const Section*> given = section.tables(tables.key);
      if (!tables.name.starts_with('[')) given.assign(1, section.table(tables.key));
      for (const Section* table : given) {
        if (table == nullptr) continue;
        for (const Entry& entry : table->entries)
          table_key(entry, tables);
        this->tables(*table, tables.described);
      }
    }
  }

  void loose(const Entry& entry) {
    if (is_command_line_option(entry.key)) return command_line_option(entry);
    std::string why;
    if (is_section(entry.key)) {
      why = fmt::format("'{0}' must be a section, with the line [{0}] above its keys; found {1}",
                        entry.key, description(entry.value));
    } else if (const std::string* home = home_of(entry.key)) {
      why = fmt::format("key '{}' is outside every section; it belongs in [{}]", entry.key, *home);
    } else {
      why = fmt::format("key '{}' is outside every section; {}", shown(entry.key),
                        meant_section(entry.key));
    }
    diagnostics_.add(entry.place, why);
  }

 private:
  void table_key(const Entry& entry, const BoundTables& tables) {
    std::vector<std::string> known;
    for (const BoundKey& bound : tables.described.keys)
      known.push_back(bound.spec.key);
    if (std::find(known.begin(), known.end(), entry.key) != known.end()) return;
    if (is_command_line_option(entry.key)) return command_line_option(entry);
    const auto near = nearest(entry.key, known);
    diagnostics_.add(entry.place,
                     fmt::format("unknown key '{}' in [{}]; {}", shown(entry.key), tables.name,
                                 near ? fmt::format("did you mean '{}'?", *near)
                                      : fmt::format("known keys: '{}'", fmt::join(known, "', '"))));
  }

  void command_line_option(const Entry& entry) {
    diagnostics_.add(entry.place,
                     fmt::format("'{}' is a command-line option, not a request key, because it "
                                 "doesn't affect results",
                                 entry.key));
  }

  bool is_section(std::string_view name) const {
    return std::find(section_names_.begin(), section_names_.end(), name) != section_names_.end();
  }

  std::string meant_section(std::string_view name) const {
    if (const auto near = nearest(name, section_names_)) {
      return fmt::format("did you mean [{}]?", *near);
    }
    return fmt::format("known sections: [{}]", fmt::join(section_names_, "], ["));
  }

  std::string meant_key(const Entry& entry, const std::vector<std::string>& known) const {
    if (const std::string* home = home_of(entry.key)) {
      return fmt::format("it belongs in [{}]", *home);
    }
    if (const auto near = nearest(entry.key, known)) {
      return fmt::format("did you mean '{}'?", *near);
    }
    for (std::size_t i = 0; i < keys_.size(); ++i) {
      if (const auto near = nearest(entry.key, keys_[i])) {
        return fmt::format("did you mean '{}' in [{}]?", *near, section_names_[i]);
      }
    }
    if (std::holds_alternative<Section>(entry.value.held)) return "sections do not nest";
    return fmt::format("known keys: '{}'", fmt::join(known, "', '"));
  }

  const std::string* home_of(std::string_view key) const {
    for (std::size_t i = 0; i < keys_.size(); ++i) {
      if (std::find(keys_[i].begin(), keys_[i].end(), key) != keys_[i].end()) {
        return &section_names_[i];
      }
    }
    return nullptr;
  }

  std::array<const Binder*, 5> sections_;
  Diagnostics& diagnostics_;
  std::vector<std::string> section_names_;
  std::vector<std::vector<std::string>> keys_;
};

void report_unknown(const Document& document, const SectionBinders& sections, bool world_known,
                    Diagnostics& diagnostics) {
  UnknownKeys unknown(sections, diagnostics);
  for (const Entry& entry : document.loose)
    unknown.loose(entry);
  for (const Section& section : document.sections) {
    const auto all = sections.all();
    const auto at = std::find_if(all.begin(), all.end(), [&](const Binder* binder) {
      return binder->section_name() == section.name;
    });
    if (at == all.end()) {
      unknown.section(section);
      continue;
    }
    const bool is_common = *at == &sections.stop || *at == &sections.output;
    for (const Entry& entry : section.entries) {
      unknown.key(entry, section.name, world_known || is_common);
    }
    unknown.tables(section, (*at)->bound());
  }
}

/// Returns whether a section exists. If the section has a wrong form, report_unknown reports that.
bool is_mentioned(const Document& document, std::string_view section) {
  return document.find(section) != nullptr ||
         std::any_of(document.loose.begin(), document.loose.end(),
                     [&](const Entry& entry) { return entry.key == section; });
}

/// Checks that scans remain after annealing and burn-in.
void check_scans(Binder& stop, const Binder& sampler, const DirectionRequest& request) {
  for (const char* key :
       {"method", "round_scans", "burn_in_rounds", "anneal_scans", "tour_scans"}) {
    if (!sampler.valid(key)) return;
  }
  if (!stop.valid("scans") || !request.stop.scans) return;
  const std::uint64_t before = scans_before_draws(request.sampler);
  if (*request.stop.scans > before) return;
  // The number of scans before draws depends on these keys. If the file has none of these keys, the
  // number is the default.
  const bool is_chosen = sampler.given("method") || sampler.given("anneal_scans") ||
                         sampler.given("burn_in_rounds") || sampler.given("round_scans") ||
                         sampler.given("tour_scans");
  stop.error("scans",
             fmt::format(
                 "expected more than {} scans, because each chain spends {} scans on annealing and "
                 "burn-in{}; found {}; set more scans, or {}",
                 before, before, is_chosen ? "" : " by default", *request.stop.scans,
                 !is_chosen ? "use independent_solutions instead"
                 : request.sampler.tour_scans
                     ? "reduce tour_scans in [sampler]"
                     : "reduce anneal_scans, burn_in_rounds or round_scans in [sampler]"));
}

void check_stop(Binder& stop, const Binder& sampler, const DirectionRequest& request) {
  // A run's rounds must not exceed the maximum scans.
  if (request.stop.rounds && sampler.valid("round_scans")) {
    const std::uint64_t scans =
        request.sampler.round_scans * ((std::uint64_t{1} << *request.stop.rounds) - 1);
    if (scans > k_scans_max) {
      stop.error(
          "rounds",
          fmt::format("the first round has {} scans, and each later round has twice as many as "
                      "the round before it, so {} rounds have {} scans per chain; the limit is {}; "
                      "use fewer rounds",
                      request.sampler.round_scans, *request.stop.rounds, scans, k_scans_max));
    }
  }

  check_scans(stop, sampler, request);

  // Plain chains have only one lineage each.
  const bool plain_chains = request.sampler.method == Method::metropolis_hastings &&
                            request.sampler.start == Start::prior;
  if (request.stop.independent_solutions && plain_chains && sampler.valid("method") &&
      sampler.valid("chains") && *request.stop.independent_solutions > request.sampler.chains) {
    stop.error("independent_solutions",
               fmt::format("expected at most {} (the number of chains), found {}; with method "
                           "\"metropolis_hastings\", each chain yields one independent solution; "
                           "set chains = {} in [sampler], or use fewer solutions",
                           request.sampler.chains, *request.stop.independent_solutions,
                           *request.stop.independent_solutions));
  }
}

/// Appends the section and its tables. A table follows its parent, as TOML requires.
void normalise(const std::string& name, const BoundSection& bound,
               std::vector<NormalisedSection>& normalised) {
  NormalisedSection section{name, {}};
  for (const BoundKey& key : bound.keys) {
    if (!key.value.empty()) section.keys.emplace_back(key.spec.key, key.value);
  }
  normalised.push_back(std::move(section));
  for (const BoundTables& tables : bound.tables) {
    for (const BoundSection& table : tables.tables)
      normalise(tables.name, table, normalised);
  }
}

/// Checks that the normalised text can be read. Its numbers may be longer than those of the file.
void check_size(const DirectionRequest& request, Diagnostics& diagnostics) {
  const std::size_t bytes = normalised_text(request).size();
  if (bytes <= k_normalised_bytes_max) return;
  diagnostics.add({}, fmt::format("the request has {} bytes when its numbers are written in full; "
                                  "the limit is {}; use fewer numbers",
                                  bytes, k_normalised_bytes_max));
}

/// Returns whether the requested world's finds can be relaxed.
bool can_be_relaxed(const Document& document, std::span<const WorldBinding> worlds) {
  const Section* world = document.find("world");
  const Entry* name = world == nullptr ? nullptr : world->find("name");
  const auto* text = name == nullptr ? nullptr : std::get_if<std::string>(&name->value.held);
  return text != nullptr && std::ranges::any_of(worlds, [&](const WorldBinding& one) {
           return one.name == *text && one.has_search && one.serve_best;
         });
}

/// Returns the rules of [stop] that request this kind of answer.
std::vector<const char*> rules_of(const Document& document, const std::optional<Answer>& answer,
                                  std::span<const WorldBinding> worlds) {
  if (answer == Answer::takes) return {"takes"};
  if (answer == Answer::found) return {"found"};
  if (answer == Answer::in_proportion) return {"independent_solutions"};
  const Section* sampler = document.find("sampler");
  const Section* stop = document.find("stop");
  const auto has_rule = [&](const char* rule) {
    return stop != nullptr && stop->find(rule) != nullptr;
  };
  const Entry* method = sampler == nullptr ? nullptr : sampler->find("method");
  const auto* name = method == nullptr ? nullptr : std::get_if<std::string>(&method->value.held);
  if (name != nullptr && *name == "search")
    return {sampler->find("relax_scans") != nullptr ? "takes" : "found"};
  const bool is_open =
      sampler == nullptr ||
      std::ranges::all_of(sampler->entries, [](const Entry& entry) { return entry.key == "seed"; });
  const std::size_t rules = stop == nullptr ? 0 : stop->entries.size();
  if (has_rule("takes") || (is_open && rules == 0 && can_be_relaxed(document, worlds)))
    return {"takes"};
  if (is_open && has_rule("found") && rules == 1) return {"found"};
  if (has_rule("found")) return {"independent_solutions", "found"};
  return {"independent_solutions"};
}

void ask_for(Document& document, const Asked& asked, std::span<const WorldBinding> worlds) {
  CHECK(asked.number >= 1 && asked.number <= k_independent_solutions_max);
  const Section* given = document.find("stop");
  Section stop{.name = "stop", .place = given == nullptr ? Place{} : given->place, .entries = {}};
  for (const char* rule : rules_of(document, asked.answer, worlds)) {
    stop.entries.push_back({.key = rule,
                            .place = stop.place,
                            .value = {.held = std::int64_t{asked.number}, .place = stop.place}});
  }
  std::erase_if(document.sections, [](const Section& section) { return section.name == "stop"; });
  document.sections.push_back(std::move(stop));
}

/// If an error has no place in the file, it belongs to a `--set`. The text of the `--set` then
/// replaces the file name.
std::vector<Diagnostic> named_by_sets(std::vector<Diagnostic> errors,
                                      std::span<const KeySet> sets) {
  for (Diagnostic& error : errors) {
    if (error.place.line != 0) continue;
    error.file = fmt::format("--set {}", sets[error.place.column - 1].text);
    error.place = k_no_place;
  }
  return errors;
}

}  // namespace

std::uint64_t scans_before_draws(const SamplerParameters& sampler) {
  if (sampler.tour_scans) return *sampler.tour_scans - 1;
  const bool has_islands = sampler.method == Method::sequential;
  const bool burns_in = has_islands || (sampler.method != Method::metropolis_hastings &&
                                        sampler.method != Method::parallel_tempering);
  const std::uint32_t by_default = has_islands ? k_island_burn_in_rounds : k_burn_in_rounds;
  const std::uint32_t rounds = burns_in ? sampler.burn_in_rounds.value_or(by_default) : 0;
  return sampler.anneal_scans.value_or(0) +
         sampler.round_scans * ((std::uint64_t{1} << rounds) - 1);
}

base::Result<DirectionRequest, std::vector<Diagnostic>> read_request(
    std::string_view text, std::string_view file, std::span<const WorldBinding> worlds,
    std::optional<Asked> asked) {
  return read_request_with(text, file, worlds, {}, asked);
}

base::Result<DirectionRequest, std::vector<Diagnostic>> read_request_with(
    std::string_view text, std::string_view file, std::span<const WorldBinding> worlds,
    std::span<const KeySet> sets, std::optional<Asked> asked) {
  auto parsed = parse_document(text, file);
  if (!parsed) return std::vector{parsed.error()};
  Document document = std::move(parsed).value();
  apply_sets(document, sets);
  if (asked) ask_for(document, *asked, worlds);

  // Read every declared key from the file.
  Diagnostics diagnostics(file);
  DirectionRequest request;
  SectionBinders sections(document, diagnostics);
  const WorldBinding* world = bind_sections(sections, worlds, request);

  // Report unknown, missing and conflicting keys.
  report_unknown(document, sections, world != nullptr, diagnostics);
  if (!is_mentioned(document, "world")) {
    diagnostics.add({}, fmt::format("missing section [world]; add it with a name, for example "
                                    "name = \"{}\"",
                                    worlds.front().name));
  }
  check_stop(sections.stop, sections.sampler, request);

  if (diagnostics.empty()) {
    for (const Binder* section : sections.all())
      normalise(section->section_name(), section->bound(), request.sections);
    check_size(request, diagnostics);
  }
  if (!diagnostics.empty()) return named_by_sets(diagnostics.sorted(), sets);
  return request;
}

}  // namespace sleight::request
