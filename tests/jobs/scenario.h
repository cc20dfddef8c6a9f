// One simulated service: its users, their jobs, what these come to, and what goes wrong, all from a
// seed.
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

/// What a job's program does when it is let run.
enum class Fate : std::uint8_t {
  finishes,
  gives_up_with_finds,
  gives_up,
  no_draws,
  simulation_fails,
  is_refused,       ///< its request is
  bug_at_a_scan,    ///< a check fails there every time
  dies_at_a_scan,   ///< every time
  stops_by_itself,  ///< in order, once, at a scan; then it finishes
};

/// Something that its user does besides.
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
  std::uint64_t fate_scan = 0;   ///< where its fate strikes
  double scan_core_s = 1;        ///< of one scan
  double queue_s = 0;            ///< in a batch system's queue before each start; 0: there is none
  double begin_s = 0.1;          ///< from the keeper's start to the first scan
  double stop_s = 0.1;           ///< from being asked to the end
  std::uint64_t disk_bytes = 0;  ///< of its folder, once it has begun
  std::vector<UserAct> acts{};
};

struct Fault {
  enum class Kind : std::uint8_t {
    server_dies,          ///< at once
    server_dies_at_save,  ///< of the next save: before it is on disk, after, or amid its effects
    keeper_dies,          ///< of one running job, or of all
    place_taken,          ///< by a batch system, of one running job: in order, or killed
    cancelled_by_hand,    ///< in a batch system, of one job that runs or waits there
    messages_lost,        ///< some of the backend's, for a time
    messages_twice,
    messages_late,   ///< so that later ones overtake them
    messages_wrong,  ///< answers that aren't so: lost keepers, launches that failed
    wall_jumps,
    disk_fills,       ///< for a time
    backend_leaves,   ///< for a time
    programs_change,  ///< for a time they are of other results
    server_drains,    ///< for a time
    machine_shrinks,  ///< for a time
  };
  Kind kind = Kind::server_dies;
  double at_s = 0;
  double for_s = 0;
  double odds = 0;          ///< of a message
  std::uint64_t which = 0;  ///< keeper, place in a save, days
};

/// Whether it takes a time.
bool lasts(Fault::Kind kind);

inline constexpr std::uint64_t k_faults_max = 60;

struct Scenario {
  std::uint64_t seed = 1;
  Mistake mistake = Mistake::none;
  Options options{};
  Room room{};
  std::vector<JobPlan> jobs{};
  std::vector<Fault> faults{};
  double quiet_s = 0;  ///< when faults and users' acts are over
  bool has(Fault::Kind kind) const;
  std::string name() const;
};

struct ScenarioChoice {
  std::uint64_t jobs_max = k_jobs_max;
  Mistake mistake = Mistake::none;
  /// What a mistake needs to show: of these the seed has some.
  std::vector<Fault::Kind> wants{};
  bool are_deleted = false;  ///< each job by its user, soon after its end, and others come later
};

Scenario scenario_of(std::uint64_t seed, const ScenarioChoice& choice = {});

/// The longest that jobs may take after the last fault; far above what they do.
double liveness_bound_s(const Scenario& scenario);

}  // namespace sleight::jobs::simulated
