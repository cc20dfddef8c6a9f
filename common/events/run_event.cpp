#include "common/events/run_event.h"

#include <limits>
#include <type_traits>
#include <utility>

#include "common/json/value.h"

namespace sleight::events {
namespace {

using Json = json::Value;

/// Reads fields of an object; what is missing or of another type makes the whole no event.
class Fields {
 public:
  explicit Fields(const Json& object) : object_(object) {}
  bool are_sound() const { return are_sound_; }

  template <class T>
  void read(const char* key, T& value) {
    const auto* found = object_.find(key);
    if (!found) {
      are_sound_ = false;
      return;
    }
    if constexpr (std::is_same_v<T, bool>) {
      if (accept(found->is_boolean())) value = found->get<bool>();
    } else if constexpr (std::is_same_v<T, std::string>) {
      if (accept(found->is_string())) value = found->get<std::string>();
    } else if constexpr (std::is_floating_point_v<T>) {
      if (accept(found->is_number())) value = found->get<T>();
    } else {
      if (!accept(found->is_whole())) return;
      const auto number = found->get<std::uint64_t>();
      if (accept(number <= std::numeric_limits<T>::max())) value = static_cast<T>(number);
    }
  }
  template <class T>
  void read(const char* key, std::optional<T>& value) {
    const auto* found = object_.find(key);
    if (found && found->is_null()) {
      value.reset();
      return;
    }
    T present{};
    read(key, present);
    value = present;
  }

 private:
  bool accept(bool holds) {
    are_sound_ = are_sound_ && holds;
    return holds;
  }
  const Json& object_;
  bool are_sound_ = true;
};

/// Writes fields into an object; the same names in the same order.
class Writer {
 public:
  explicit Writer(Json& object) : object_(object) {}
  template <class T>
  void read(const char* key, const T& value) {
    object_[key] = value;
  }
  template <class T>
  void read(const char* key, const std::optional<T>& value) {
    object_[key] = value ? Json(*value) : Json(nullptr);
  }

 private:
  Json& object_;
};

// Each kind's fields, once for both ways.
template <class Visitor, class T>
void visit_fields(Visitor& fields, T& what) {
  using Kind = std::remove_const_t<T>;
  if constexpr (std::is_same_v<Kind, Phase>) {
    fields.read("words", what.words);
  } else if constexpr (std::is_same_v<Kind, Progress>) {
    fields.read("scans_done", what.scans_done);
    fields.read("scans_total", what.scans_total);
    fields.read("session_scans", what.session_scans);
    fields.read("session_satisfied", what.session_satisfied);
    fields.read("session_proposed", what.session_proposed);
    fields.read("session_accepted", what.session_accepted);
    fields.read("session_simulations", what.session_simulations);
    fields.read("solutions", what.solutions);
    fields.read("solutions_wanted", what.solutions_wanted);
    fields.read("found", what.finds.found);
    fields.read("found_wanted", what.finds.wanted);
    fields.read("gave_up", what.finds.gave_up);
    fields.read("stuck_at", what.finds.stuck_at);
    fields.read("search_is_all", what.finds.is_all);
    fields.read("relaxed", what.finds.relaxed);
    fields.read("relaxed_wanted", what.finds.relaxed_wanted);
    fields.read("found_s", what.found_s);
    fields.read("round_trips", what.round_trips);
    fields.read("odds_asked", what.odds.are_asked);
    fields.read("odds_islands", what.odds.islands);
    fields.read("odds_islands_wanted", what.odds.wanted);
    fields.read("log_p", what.odds.log_p);
    fields.read("log_p_error", what.odds.log_error);
    fields.read("odds_are_known", what.odds.is_final);
    fields.read("prior_draws", what.prior_draws);
    fields.read("prior_draws_wanted", what.prior_draws_wanted);
    for (std::size_t kind = 0; kind < plan::k_failure_kinds; ++kind)
      fields.read(plan::k_failure_names[kind].data(), what.failures.by_kind[kind]);
    fields.read("workers", what.workers);
    fields.read("elapsed_s", what.elapsed_s);
  } else if constexpr (std::is_same_v<Kind, Solution>) {
    fields.read("nth", what.nth);
    fields.read("in_proportion", what.in_proportion);
    fields.read("chain", what.chain);
    fields.read("scan", what.scan);
    fields.read("log_p", what.log_p);
  } else if constexpr (std::is_same_v<Kind, Failure>) {
    fields.read("simulation", what.simulation);
    fields.read("chain", what.chain);
    fields.read("replica", what.replica);
    fields.read("scan", what.scan);
    fields.read("file", what.file);
  } else if constexpr (std::is_same_v<Kind, RoundEnded>) {
    fields.read("chain", what.chain);
    fields.read("round", what.round);
    fields.read("scans", what.scans);
    fields.read("swaps", what.swaps);
    fields.read("round_trips", what.round_trips);
  } else {
    static_assert(std::is_same_v<Kind, ArchiveWritten>);
    fields.read("digest", what.digest);
    fields.read("scans", what.scans);
    fields.read("found", what.found);
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

/// Reads a kind if the object is of it.
template <class T>
bool read_kind(std::string_view kind, const Json& object, std::optional<RunEvent>& event) {
  if (kind != k_name<T>) return false;
  RunEvent read;
  Fields fields(object);
  fields.read("number", read.number);
  if constexpr (std::is_same_v<T, RunEnd>) {
    const auto* end = object.find("end");
    if (!end) return true;
    auto run_end = run_end_of(end->dump());
    if (run_end && fields.are_sound()) {
      read.what = *std::move(run_end);
      event = std::move(read);
    }
  } else {
    T what{};
    visit_fields(fields, what);
    if (fields.are_sound()) {
      read.what = std::move(what);
      event = std::move(read);
    }
  }
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
          Writer fields(object);
          visit_fields(fields, what);
        }
      },
      event.what);
  return object.dump() + "\n";
}

std::optional<RunEvent> run_event_of(std::string_view line) {
  const Json object = Json::parse_or_null(line);
  if (!object.is_object()) return std::nullopt;
  const auto* kind = object.find("kind");
  if (!kind || !kind->is_string()) return std::nullopt;
  std::optional<RunEvent> event;
  read_any(static_cast<decltype(RunEvent::what)*>(nullptr), kind->get<std::string>(), object,
           event);
  return event;
}

}  // namespace sleight::events
