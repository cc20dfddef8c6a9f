#include "service/daemon/job_records.h"

#include <cmath>
#include <stdexcept>
#include <type_traits>
#include <utility>

#include "common/json/value.h"

namespace sleight::daemon {
namespace {

using Json = json::Value;

/// A record that was not written here.
struct NotOurs : std::runtime_error {
  NotOurs() : std::runtime_error("not a record of ours") {}
};

/// Writes each field that it is shown.
class Writer {
 public:
  explicit Writer(Json& json) : json_(json) {}
  template <class T>
  void operator()(const char* name, const T& value) {
    json_[name] = value;
  }
  template <class Tag, class T>
  void operator()(const char* name, const base::Id<Tag, T>& id) {
    json_[name] = id.value;
  }
  template <class T>
  void operator()(const char* name, const std::optional<T>& value) {
    if (value) (*this)(name, *value);
  }
  template <class Enum, class Named>
  void choice(const char* name, const Enum& value, const Named&) {
    json_[name] = name_of(value);
  }
  template <class Struct, class Fields>
  void part(const char* name, Struct& value, const Fields& fields) {
    Writer inner(json_[name]);
    fields(inner, value);
  }

 private:
  Json& json_;
};

/// Reads each field that it is shown, if it is there.
class Reader {
 public:
  explicit Reader(const Json& json) : json_(json) {
    if (!json.is_object()) throw NotOurs();
  }
  template <class T>
  void operator()(const char* name, T& value) {
    const auto* at = json_.find(name);
    if (!at) return;
    if constexpr (std::is_unsigned_v<T> && !std::is_same_v<T, bool>) {
      if (!at->is_whole()) throw NotOurs();
      const auto number = at->template get<std::uint64_t>();
      value = static_cast<T>(number);
      if (value != number) throw NotOurs();
    } else {
      value = at->template get<T>();
    }
  }
  template <class Tag, class T>
  void operator()(const char* name, base::Id<Tag, T>& id) {
    (*this)(name, id.value);
  }
  template <class T>
  void operator()(const char* name, std::optional<T>& value) {
    if (!json_.contains(name)) return;
    (*this)(name, value.emplace());
  }
  template <class Enum, class Named>
  void choice(const char* name, Enum& value, const Named& value_of) {
    const auto* at = json_.find(name);
    if (!at) return;
    const auto found = value_of(at->template get<std::string>());
    if (!found) throw NotOurs();
    value = *found;
  }
  template <class Struct, class Fields>
  void part(const char* name, Struct& value, const Fields& fields) {
    const auto* at = json_.find(name);
    if (!at) return;
    Reader inner(*at);
    fields(inner, value);
  }

 private:
  const Json& json_;
};

template <class Visit, class Wishes>
void wishes_fields(Visit& visit, Wishes& wishes) {
  visit("cores", wishes.cores);
  visit("ranks", wishes.ranks);
  visit("memory_bytes", wishes.memory_bytes);
}

template <class Visit, class Counts>
void counts_fields(Visit& visit, Counts& counts) {
  visit("scans", counts.scans);
  visit("found", counts.found);
  visit("solutions", counts.solutions);
  visit("failures", counts.failures);
}

// Each list of fields serves for writing and for reading, so that neither forgets one.

template <class Visit, class Job>
void job_fields(Visit& visit, Job& job) {
  const auto state_of = [](const std::string& name) { return jobs::state_of(name); };
  const auto reason_of = [](const std::string& name) { return jobs::reason_of(name); };
  const auto end_of = [](const std::string& name) { return jobs::end_kind_of(name); };
  visit("id", job.id);
  visit("user", job.user);
  visit("client_key", job.client_key);
  visit("content", job.content);
  visit("name", job.name);
  visit("group", job.group);
  visit("priority", job.priority);
  visit.part("wishes", job.wishes, [](auto& v, auto& part) { wishes_fields(v, part); });
  visit("pinned", job.pinned);
  visit("revision", job.revision);
  visit("is_leaving", job.is_leaving);
  visit.choice("state", job.state, state_of);
  visit.choice("reason", job.reason, reason_of);
  visit("words", job.words);
  visit("attempt", job.attempt);
  visit("attempt_revision", job.attempt_revision);
  visit("cores", job.cores);
  visit("attempt_begin_s", job.attempt_begin_s);
  visit.part("counts", job.counts, [](auto& v, auto& part) { counts_fields(v, part); });
  visit("scans_at_attempt", job.scans_at_attempt);
  visit("results_version", job.results_version);
  visit("deaths", job.deaths);
  visit("scans_at_death", job.scans_at_death);
  visit("back_offs", job.back_offs);
  visit("bug_place", job.bug_place);
  visit("scans_at_bug", job.scans_at_bug);
  visit("fruitless", job.fruitless);
  visit("next_start_s", job.next_start_s);
  visit("start_cost_s", job.start_cost_s);
  visit("stop_cost_s", job.stop_cost_s);
  visit("core_seconds", job.core_seconds);
  visit("disk_bytes", job.disk_bytes);
  visit.choice("end", job.end, end_of);
  visit("digest", job.digest);
  visit("queued_since_s", job.queued_since_s);
  visit("over_since_s", job.over_since_s);
  visit("remove_at_s", job.remove_at_s);
  visit("submitted_wall", job.submitted_wall);
  visit("began_wall", job.began_wall);
  visit("over_wall", job.over_wall);
  visit("changed_wall", job.changed_wall);
  visit("next_start_wall", job.next_start_wall);
  visit("remove_wall", job.remove_wall);
}

template <class Visit, class Change>
void change_fields(Visit& visit, Change& change) {
  const auto state_of = [](const std::string& name) { return jobs::state_of(name); };
  const auto reason_of = [](const std::string& name) { return jobs::reason_of(name); };
  visit("id", change.id);
  visit.choice("from", change.from, state_of);
  visit.choice("to", change.to, state_of);
  visit.choice("reason", change.reason, reason_of);
  visit("attempt", change.attempt);
  visit("wall", change.wall);
  visit("words", change.words);
}

template <class Visit, class Usage>
void usage_fields(Visit& visit, Usage& usage) {
  visit("user", usage.user);
  visit("at_s", usage.at_s);
  visit("share_core_s", usage.share_core_s);
  visit("allowance_core_s", usage.allowance_core_s);
}

template <class Value, class Fields>
std::string line_of(const Value& value, const Fields& fields) {
  Json json = Json::object();
  Writer writer(json);
  fields(writer, value);
  // Words of programs may hold any bytes.
  return json.dump();
}

template <class Value, class Fields>
std::optional<Value> value_of(std::string_view line, const Fields& fields) {
  try {
    const Json json = Json::parse(line);
    Value value{};
    Reader reader(json);
    fields(reader, value);
    return value;
  } catch (const json::Error&) {
    return std::nullopt;
  } catch (const NotOurs&) {
    return std::nullopt;
  }
}

constexpr auto k_job = [](auto& visit, auto& job) { job_fields(visit, job); };
constexpr auto k_change = [](auto& visit, auto& change) { change_fields(visit, change); };
constexpr auto k_usage = [](auto& visit, auto& usage) { usage_fields(visit, usage); };

}  // namespace

std::string to_line(const jobs::Job& job) {
  return line_of(job, k_job);
}
std::string to_line(const jobs::Change& change) {
  return line_of(change, k_change);
}
std::string to_line(const jobs::Usage& usage) {
  return line_of(usage, k_usage);
}

std::optional<jobs::Job> job_of(std::string_view line) {
  return value_of<jobs::Job>(line, k_job);
}
std::optional<jobs::Change> change_of(std::string_view line) {
  return value_of<jobs::Change>(line, k_change);
}
std::optional<jobs::Usage> usage_of(std::string_view line) {
  return value_of<jobs::Usage>(line, k_usage);
}

}  // namespace sleight::daemon
