// A simulated service: its users, jobs, the jobs' fates, and faults. A seed determines all of them.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "service/jobs/jobs.h"
#include "tests/jobs/mistakes.h"

namespace sleight::jobs::simulated {

inline constexpr std::uint64_t k_jobs_max = 1000;
inline constexpr std::uint32_t k_users_max = 20;

enum class Fate : std::uint8_t {
  finishes,
  gives_up_with_finds,
  gives_up,
  no_draws,
  simulation_fails,
  is_refused,       ///< its request is refused
  bug_at_a_scan,    ///< a check fails there every time
  dies_at_a_scan,   ///< every time
  stops_by_itself,  ///< once, cleanly, at a scan; then it finishes
};

/// A user's action on a job after its submission.
struct UserAct {
  AskKind kind = AskKind::cancel;
  double at_s = 0;
};

struct JobPlan {
  UserId user;
  double submitted_s = 0;
  bool is_submitted_twice = false;
  std::int32_t priority = 0;
  Wishes wishes{};
  Fate fate = Fate::finishes;
  std::uint64_t scans = 1;       ///< of its request; each extension adds as many
  std::uint64_t fate_scan = 0;   ///< the scan of its fate
  double scan_core_s = 1;        ///< of one scan
  double queue_s = 0;            ///< in a batch system's queue before each start; 0: no queue
  double begin_s = 0.1;          ///< from the keeper's start to the first scan
  double stop_s = 0.1;           ///< from the stop request to the end
  std::uint64_t disk_bytes = 0;  ///< of its folder, once it has begun
  std::vector<UserAct> acts{};
};

struct Fault {
  enum class Kind : std::uint8_t {
    server_dies,          ///< at once
    server_dies_at_save,  ///< during the next save: before, after, or amid its effects
    keeper_dies,          ///< the keeper of one or of all running jobs
    place_taken,          ///< a batch system stops or kills one running job
    cancelled_by_hand,    ///< one job in a batch system, waiting or running
    messages_lost,        ///< temporarily
    messages_twice,
    messages_late,   ///< so later ones overtake them
    messages_wrong,  ///< false answers: lost keepers, failed launches
    wall_jumps,
    disk_fills,       ///< temporarily
    backend_leaves,   ///< temporarily
    programs_change,  ///< temporarily of another results version
    server_drains,    ///< temporarily
    machine_shrinks,  ///< temporarily
  };
  Kind kind = Kind::server_dies;
  double at_s = 0;
  double for_s = 0;
  double odds = 0;          ///< per message
  std::uint64_t which = 0;  ///< keeper, place in a save, days
};

/// Whether the fault has a duration.
bool lasts(Fault::Kind kind);

inline constexpr std::uint64_t k_faults_max = 60;

struct Scenario {
  std::uint64_t seed = 1;
  Mistake mistake = Mistake::none;
  Options options{};
  Room room{};
  std::vector<JobPlan> jobs{};
  std::vector<Fault> faults{};
  double quiet_s = 0;  ///< after the last fault and user act
  bool has(Fault::Kind kind) const;
  std::string name() const;
};

struct ScenarioChoice {
  std::uint64_t jobs_max = k_jobs_max;
  Mistake mistake = Mistake::none;
  /// Kinds of faults that reveal the mistake. The scenario includes some faults of these kinds.
  std::vector<Fault::Kind> wants{};
  bool are_deleted = false;  ///< each user deletes each job soon after its end
};

Scenario scenario_of(std::uint64_t seed, const ScenarioChoice& choice = {});

/// Maximum time from the last fault to the end of all jobs. The actual time is far shorter.
double liveness_bound_s(const Scenario& scenario);

}  // namespace sleight::jobs::simulated
