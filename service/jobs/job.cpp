#include "service/jobs/job.h"

#include <algorithm>
#include <array>
#include <utility>

#include "common/base/check.h"
#include "service/jobs/messages.h"

namespace sleight::jobs {
namespace {

template <class Enum, std::size_t size>
using Names = std::array<std::pair<Enum, std::string_view>, size>;

template <class Enum, std::size_t size>
std::string_view name_in(const Names<Enum, size>& names, Enum value) {
  const auto found = std::ranges::find(names, value, [](const auto& entry) { return entry.first; });
  CHECK(found != names.end());
  return found->second;
}

template <class Enum, std::size_t size>
std::optional<Enum> value_in(const Names<Enum, size>& names, std::string_view name) {
  const auto found = std::ranges::find(names, name, [](const auto& entry) { return entry.second; });
  if (found == names.end()) return std::nullopt;
  return found->first;
}

constexpr Names<State, 8> k_states{{{State::queued, "queued"},
                                    {State::starting, "starting"},
                                    {State::running, "running"},
                                    {State::yielding, "yielding"},
                                    {State::held, "held"},
                                    {State::done, "done"},
                                    {State::failed, "failed"},
                                    {State::cancelled, "cancelled"}}};

constexpr Names<Reason, 29> k_reasons{{{Reason::submitted, "submitted"},
                                       {Reason::resumed, "resumed"},
                                       {Reason::extended, "extended"},
                                       {Reason::its_turn, "its_turn"},
                                       {Reason::began, "began"},
                                       {Reason::found_running, "found_running"},
                                       {Reason::others_wait, "others_wait"},
                                       {Reason::wider, "wider"},
                                       {Reason::less_room, "less_room"},
                                       {Reason::draining, "draining"},
                                       {Reason::stopped_by_itself, "stopped_by_itself"},
                                       {Reason::died, "died"},
                                       {Reason::hold_asked, "hold_asked"},
                                       {Reason::cancel_asked, "cancel_asked"},
                                       {Reason::disk_low, "disk_low"},
                                       {Reason::disk_full, "disk_full"},
                                       {Reason::limit_core_hours, "limit_core_hours"},
                                       {Reason::limit_bytes, "limit_bytes"},
                                       {Reason::backend_away, "backend_away"},
                                       {Reason::other_results, "other_results"},
                                       {Reason::taken_away, "taken_away"},
                                       {Reason::cancelled_outside, "cancelled_outside"},
                                       {Reason::went_on, "went_on"},
                                       {Reason::finished, "finished"},
                                       {Reason::gave_up, "gave_up"},
                                       {Reason::no_draws, "no_draws"},
                                       {Reason::simulation_failed, "simulation_failed"},
                                       {Reason::bug, "bug"},
                                       {Reason::refused_by_program, "refused_by_program"}}};

constexpr Names<EndKind, 9> k_ends{{{EndKind::none, "none"},
                                    {EndKind::finished, "finished"},
                                    {EndKind::gave_up, "gave_up"},
                                    {EndKind::no_draws, "no_draws"},
                                    {EndKind::time_limit, "time_limit"},
                                    {EndKind::stop_requested, "stop_requested"},
                                    {EndKind::simulation_failed, "simulation_failed"},
                                    {EndKind::failed, "failed"},
                                    {EndKind::bug, "bug"}}};

constexpr Names<RefusalKind, 6> k_refusals{{{RefusalKind::not_found, "not_found"},
                                            {RefusalKind::not_allowed, "not_allowed"},
                                            {RefusalKind::key_in_use, "key_in_use"},
                                            {RefusalKind::over_limit, "over_limit"},
                                            {RefusalKind::too_large, "too_large"},
                                            {RefusalKind::wrong_state, "wrong_state"}}};

}  // namespace

std::string_view name_of(State state) {
  return name_in(k_states, state);
}
std::string_view name_of(Reason reason) {
  return name_in(k_reasons, reason);
}
std::string_view name_of(EndKind kind) {
  return name_in(k_ends, kind);
}
std::string_view name_of(RefusalKind kind) {
  return name_in(k_refusals, kind);
}
std::optional<State> state_of(std::string_view name) {
  return value_in(k_states, name);
}
std::optional<Reason> reason_of(std::string_view name) {
  return value_in(k_reasons, name);
}
std::optional<EndKind> end_kind_of(std::string_view name) {
  return value_in(k_ends, name);
}

}  // namespace sleight::jobs
