// Known mistakes for tests. A mistake is in one part of the code around the machine of jobs, or in
// one setting.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>
#include <utility>

namespace sleight::jobs::simulated {

enum class Mistake : std::uint8_t {
  none,
  effects_before_save,      ///< carried out during the save
  save_lost,                ///< sometimes acknowledged but not on disk
  half_a_save,              ///< a job's record without its history
  ids_come_again,           ///< the next id follows the remaining jobs
  done_runs_again,          ///< after a restart
  open_attempts_forgotten,  ///< a restart queues them without a look
  any_attempt_counts,       ///< reports of an older attempt count for the newest
  same_attempt_again,       ///< a restart after a death reuses the number
  stops_forgotten,          ///< no stop is sent
  looks_forgotten,          ///< no look is sent
  keys_ignored,             ///< a repeated submit creates a second job
  one_core_too_many,        ///< of the machine
  memory_not_counted,
  reserve_ignored,      ///< of disk space
  user_limit_ignored,   ///< of cores
  exit_code_decides,    ///< instead of the record
  commits_not_counted,  ///< between deaths
  deaths_for_ever,      ///< a job restarts however often it dies
  no_back_off,
  bug_is_a_death,  ///< a bug fails a job only after five deaths
  wall_clock_decides,
  deleted_unannounced,
  cancelled_goes_on,  ///< a job cancelled in the batch system starts again
};

inline constexpr std::array k_mistakes{
    std::pair{Mistake::effects_before_save, std::string_view("effects_before_save")},
    std::pair{Mistake::save_lost, std::string_view("save_lost")},
    std::pair{Mistake::half_a_save, std::string_view("half_a_save")},
    std::pair{Mistake::ids_come_again, std::string_view("ids_come_again")},
    std::pair{Mistake::done_runs_again, std::string_view("done_runs_again")},
    std::pair{Mistake::open_attempts_forgotten, std::string_view("open_attempts_forgotten")},
    std::pair{Mistake::any_attempt_counts, std::string_view("any_attempt_counts")},
    std::pair{Mistake::same_attempt_again, std::string_view("same_attempt_again")},
    std::pair{Mistake::stops_forgotten, std::string_view("stops_forgotten")},
    std::pair{Mistake::looks_forgotten, std::string_view("looks_forgotten")},
    std::pair{Mistake::keys_ignored, std::string_view("keys_ignored")},
    std::pair{Mistake::one_core_too_many, std::string_view("one_core_too_many")},
    std::pair{Mistake::memory_not_counted, std::string_view("memory_not_counted")},
    std::pair{Mistake::reserve_ignored, std::string_view("reserve_ignored")},
    std::pair{Mistake::user_limit_ignored, std::string_view("user_limit_ignored")},
    std::pair{Mistake::exit_code_decides, std::string_view("exit_code_decides")},
    std::pair{Mistake::commits_not_counted, std::string_view("commits_not_counted")},
    std::pair{Mistake::deaths_for_ever, std::string_view("deaths_for_ever")},
    std::pair{Mistake::no_back_off, std::string_view("no_back_off")},
    std::pair{Mistake::bug_is_a_death, std::string_view("bug_is_a_death")},
    std::pair{Mistake::wall_clock_decides, std::string_view("wall_clock_decides")},
    std::pair{Mistake::deleted_unannounced, std::string_view("deleted_unannounced")},
    std::pair{Mistake::cancelled_goes_on, std::string_view("cancelled_goes_on")},
};

}  // namespace sleight::jobs::simulated
