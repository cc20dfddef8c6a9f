#include "common/events/run_event.h"

#include <type_traits>
#include <utility>

#include "common/json/fields.h"

namespace sleight::events {
namespace {

using Json = json::Value;

// Lists the fields of each kind of event. The reader and the writer both use these lists.
template <class Visitor, class T>
void visit_fields(Visitor& fields, T& what) {
  using Kind = std::remove_const_t<T>;
  if constexpr (std::is_same_v<Kind, Phase>) {
    fields("words", what.words);
  } else if constexpr (std::is_same_v<Kind, Progress>) {
    fields("scans_done", what.scans_done);
    fields("scans_total", what.scans_total);
    fields("session_scans", what.session_scans);
    fields("session_satisfied", what.session_satisfied);
    fields("session_proposed", what.session_proposed);
    fields("session_accepted", what.session_accepted);
    fields("session_simulations", what.session_simulations);
    fields("solutions", what.solutions);
    fields("solutions_wanted", what.solutions_wanted);
    fields("found", what.finds.found);
    fields("found_wanted", what.finds.wanted);
    fields("gave_up", what.finds.gave_up);
    fields("gave_up_because", what.finds.gave_up_because);
    fields("search_is_all", what.finds.is_all);
    fields("relaxed", what.finds.relaxed);
    fields("relaxed_wanted", what.finds.relaxed_wanted);
    fields("found_s", what.found_s);
    fields("round_trips", what.round_trips);
    fields("odds_asked", what.odds.are_asked);
    fields("odds_islands", what.odds.islands);
    fields("odds_islands_wanted", what.odds.wanted);
    fields("log_p", what.odds.log_p);
    fields("log_p_error", what.odds.log_error);
    fields("odds_are_known", what.odds.is_final);
    fields("prior_draws", what.prior_draws);
    fields("prior_draws_wanted", what.prior_draws_wanted);
    for (std::size_t kind = 0; kind < plan::k_failure_kinds; ++kind)
      fields(plan::k_failure_names[kind].data(), what.failures.by_kind[kind]);
    fields("workers", what.workers);
    fields("elapsed_s", what.elapsed_s);
  } else if constexpr (std::is_same_v<Kind, Solution>) {
    fields("nth", what.nth);
    fields("in_proportion", what.in_proportion);
    fields("chain", what.chain);
    fields("scan", what.scan);
    fields("log_p", what.log_p);
  } else if constexpr (std::is_same_v<Kind, Failure>) {
    fields("simulation", what.simulation);
    fields("chain", what.chain);
    fields("replica", what.replica);
    fields("scan", what.scan);
    fields("file", what.file);
  } else if constexpr (std::is_same_v<Kind, RoundEnded>) {
    fields("chain", what.chain);
    fields("round", what.round);
    fields("scans", what.scans);
    fields("swaps", what.swaps);
    fields("round_trips", what.round_trips);
  } else {
    static_assert(std::is_same_v<Kind, ArchiveWritten>);
    fields("digest", what.digest);
    fields("scans", what.scans);
    fields("found", what.found);
  }
}

template <class T>
constexpr std::string_view k_name = "";
template <>
constexpr std::string_view k_name<Phase> = "phase";
template <>
constexpr std::string_view k_name<Progress> = "progress";
template <>
constexpr std::string_view k_name<Solution> = "solution";
template <>
constexpr std::string_view k_name<Failure> = "failure";
template <>
constexpr std::string_view k_name<RoundEnded> = "round_ended";
template <>
constexpr std::string_view k_name<ArchiveWritten> = "archive_written";
template <>
constexpr std::string_view k_name<RunEnd> = "ended";

/// Reads the event if `kind` matches. Throws json::Error for invalid fields.
template <class T>
bool read_kind(std::string_view kind, const Json& object, std::optional<RunEvent>& event) {
  if (kind != k_name<T>) return false;
  RunEvent read;
  json::FieldReader fields(object, json::None::null);
  fields("number", read.number);
  if constexpr (std::is_same_v<T, RunEnd>) {
    auto end = run_end_of(object.at("end").dump());
    if (!end) return true;
    read.what = *std::move(end);
  } else {
    visit_fields(fields, read.what.emplace<T>());
  }
  event = std::move(read);
  return true;
}

template <class... Kinds>
void read_any(std::variant<Kinds...>* /*kinds*/, std::string_view kind, const Json& object,
              std::optional<RunEvent>& event) {
  static_cast<void>((read_kind<Kinds>(kind, object, event) || ...));
}

}  // namespace

std::string_view kind_of(const RunEvent& event) {
  return std::visit([](const auto& what) { return k_name<std::decay_t<decltype(what)>>; },
                    event.what);
}

std::string to_line(const RunEvent& event) {
  Json object{{"number", event.number}, {"kind", kind_of(event)}};
  std::visit(
      [&](const auto& what) {
        if constexpr (std::is_same_v<std::decay_t<decltype(what)>, RunEnd>) {
          object["end"] = Json::parse(to_line(what));
        } else {
          json::FieldWriter fields(object, json::None::null);
          visit_fields(fields, what);
        }
      },
      event.what);
  return object.dump() + "\n";
}

std::optional<RunEvent> run_event_of(std::string_view line) {
  std::optional<RunEvent> event;
  try {
    const Json object = Json::parse(line);
    read_any(static_cast<decltype(RunEvent::what)*>(nullptr), object.at("kind").text(), object,
             event);
  } catch (const json::Error&) {
    return std::nullopt;
  }
  return event;
}

}  // namespace sleight::events
