// Tests turns in simulated time: users' shares, short jobs, large jobs, patience, and the cost of
// turns.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <map>
#include <vector>

#include "tests/jobs/service.h"

namespace sleight::jobs::simulated {
namespace {

constexpr UserId k_ann{1};
constexpr UserId k_bob{2};

/// Returns a job that takes 0.2 s to start, 0.1 s per scan, and 0.1 s to stop. So a restart costs
/// under 0.5 s.
JobPlan job_of(UserId user, double at_s, double core_s) {
  return {.user = user,
          .submitted_s = at_s,
          .scans = static_cast<std::uint64_t>(std::ceil(core_s / 0.1)),
          .scan_core_s = 0.1,
          .begin_s = 0.2,
          .stop_s = 0.1,
          .disk_bytes = 1};
}

constexpr double k_endless_core_s = 1e9;

Scenario quiet_machine(std::uint32_t cores, double until_s) {
  Scenario scenario;
  scenario.room = {.cores = cores,
                   .memory_bytes = 1'000'000,
                   .disk_free_bytes = 1'000'000,
                   .disk_reserve_bytes = 1'000};
  scenario.quiet_s = until_s;
  return scenario;
}

struct Split {
  std::uint32_t cores = 1;
  std::size_t anns_jobs = 1;
  std::size_t bobs_jobs = 1;
  std::uint32_t anns_wish = 0;
};

double difference_of_shares(const Split& split) {
  constexpr double k_span_s = 600;
  Scenario scenario = quiet_machine(split.cores, k_span_s);
  for (std::size_t i = 0; i < split.anns_jobs; ++i) {
    scenario.jobs.push_back(job_of(k_ann, 0, k_endless_core_s));
    scenario.jobs.back().wishes.cores = split.anns_wish;
  }
  for (std::size_t i = 0; i < split.bobs_jobs; ++i)
    scenario.jobs.push_back(job_of(k_bob, 0, k_endless_core_s));
  Service service(scenario);
  const Outcome outcome = service.run(0);
  EXPECT_EQ(outcome.violation, "");
  const double anns = service.backend().core_s_of(k_ann);
  const double bobs = service.backend().core_s_of(k_bob);
  EXPECT_GE(anns + bobs, 0.85 * k_span_s * split.cores);
  return std::abs(anns - bobs) / (anns + bobs);
}

TEST(Turns, TwoUsersHaveEqualShares) {
  // Goal: over ten minutes, two users' shares of the machine differ by under 5%, for even and odd
  // numbers of cores and any numbers of jobs. Method: run endless jobs of both users, and compare
  // the core-seconds that each user gets.
  for (const Split& split :
       {Split{.cores = 1}, Split{.cores = 2}, Split{.cores = 3}, Split{.cores = 10},
        Split{.cores = 1, .anns_jobs = 9}, Split{.cores = 10, .anns_jobs = 9},
        Split{.cores = 10, .anns_jobs = 9, .anns_wish = 1},
        Split{.cores = 7, .anns_jobs = 50, .bobs_jobs = 2, .anns_wish = 2}}) {
    const double difference = difference_of_shares(split);
    fmt::print("{} cores, {} against {} jobs: shares differ by {:.1f}%\n", split.cores,
               split.anns_jobs, split.bobs_jobs, 100 * difference);
    EXPECT_LT(difference, 0.05) << split.cores << " cores, " << split.anns_jobs << " jobs";
  }
}

TEST(Turns, AShortJobEndsSoon) {
  // Goal: even if one user's jobs fill the machine, another user's job of 2 s ends within 15 s.
  // Method: let Ann's jobs use all cores. In some cases, more of Ann's jobs wait. Let Bob submit
  // jobs at sixty different moments.
  double longest_s = 0;
  for (const std::uint32_t cores : {1U, 2U, 8U}) {
    for (const std::size_t anns_jobs : {1UL, 20UL}) {
      Scenario scenario = quiet_machine(cores, 0);
      for (std::size_t i = 0; i < anns_jobs; ++i)
        scenario.jobs.push_back(job_of(k_ann, 0, k_endless_core_s));
      for (int visit = 0; visit < 10; ++visit)
        scenario.jobs.push_back(job_of(k_bob, 50 + 14.3 * visit, 2));
      Service service(scenario);
      std::map<std::size_t, double> over_s;
      for (double at_s = 50; at_s < 250; at_s += 0.1) {
        service.at(at_s, [&] {
          for (std::size_t i = anns_jobs; i < scenario.jobs.size(); ++i) {
            const Job* job = service.job(i);
            if (job != nullptr && job->state == State::done) over_s.try_emplace(i, service.now_s());
          }
        });
      }
      EXPECT_EQ(service.run(250).violation, "");
      for (std::size_t i = anns_jobs; i < scenario.jobs.size(); ++i) {
        ASSERT_TRUE(over_s.contains(i)) << "visit " << i - anns_jobs;
        longest_s = std::max(longest_s, over_s.at(i) - scenario.jobs[i].submitted_s);
      }
    }
  }
  fmt::print("a job of 2 s ends after {:.1f} s at most\n", longest_s);
  EXPECT_LT(longest_s, 15);
}

/// Returns the nth job's longest wait, counted from its submission or its last attempt.
double longest_wait_s(Service& service, std::size_t nth, double until_s) {
  struct Watch {
    double since_s = -1;
    double longest_s = 0;
  };
  const auto watch = std::make_shared<Watch>();
  for (double at_s = 0; at_s < until_s; at_s += 1) {
    service.at(at_s, [&service, nth, watch] {
      const Job* job = service.job(nth);
      if (job == nullptr || job->state != State::queued) {
        watch->since_s = -1;
        return;
      }
      if (watch->since_s < 0) watch->since_s = service.now_s();
      watch->longest_s = std::max(watch->longest_s, service.now_s() - watch->since_s);
    });
  }
  service.run(until_s);
  return watch->longest_s;
}

TEST(Turns, ALargeJobGetsItsRoom) {
  // Goal: a stream of small jobs doesn't starve a job that needs the whole machine. The user of the
  // large job may even have used the machine most. Method: let each of 19 users always have jobs of
  // one core waiting. Let Ann submit a job of eight ranks. Ann submits this job at the start, or
  // after another job of hers has used the machine for an hour. The patience is ten minutes.
  for (const double head_start_s : {0.0, 3600.0}) {
    Scenario scenario = quiet_machine(8, 0);
    scenario.options.patience_s = 600;
    const double end_s = head_start_s + 1500;
    scenario.jobs.push_back(job_of(k_ann, head_start_s + 300, 400));
    scenario.jobs.back().wishes.ranks = 8;
    if (head_start_s > 0) scenario.jobs.push_back(job_of(k_ann, 0, 7.5 * head_start_s));
    for (std::uint32_t user = 0; user < 19; ++user) {
      for (double at_s = head_start_s; at_s < end_s; at_s += 40) {
        scenario.jobs.push_back(job_of(UserId{100 + user}, at_s, 0));
        scenario.jobs.back().wishes.cores = 1;
        scenario.jobs.back().scans = 20;
        scenario.jobs.back().scan_core_s = 1;
      }
    }
    Service service(scenario);
    const double wait_s = longest_wait_s(service, 0, end_s);
    fmt::print("eight ranks wait {:.0f} s, where their user had {:.0f} s of the machine\n", wait_s,
               head_start_s);
    // The wait is at most the patience, plus a slice of the running jobs, plus the time to stop
    // them.
    EXPECT_LT(wait_s, scenario.options.patience_s + 40);
    ASSERT_NE(service.job(0), nullptr);
    EXPECT_GT(service.job(0)->attempt.value, 0U);
  }
}

TEST(Turns, NobodyStarves) {
  // Goal: no user waits longer than the bound in jobs.h. Method: give twenty users endless jobs on
  // one core. One user has used the core for hours, another has long scans, and a third has a low
  // priority. The patience is ten minutes.
  Scenario scenario = quiet_machine(1, 0);
  scenario.options.patience_s = 600;
  constexpr double k_begin_s = 8000, k_end_s = 20'000;
  scenario.jobs.push_back(job_of(k_ann, 0, k_endless_core_s));
  for (std::uint32_t user = 2; user <= 20; ++user)
    scenario.jobs.push_back(job_of(UserId{user}, k_begin_s, k_endless_core_s));
  scenario.jobs[5].scan_core_s = 45;
  JobPlan low = job_of(k_bob, k_begin_s, k_endless_core_s);
  low.priority = -5;
  scenario.jobs.push_back(low);
  Service service(scenario);
  const double anns_wait_s = longest_wait_s(service, 0, k_end_s);
  const double slices_s = 20 * (scenario.options.slice_uncommitted_s + 1);
  fmt::print("a user who had two hours waits {:.0f} s at most\n", anns_wait_s);
  EXPECT_LT(anns_wait_s, scenario.options.patience_s + slices_s);
  for (std::size_t i = 0; i < scenario.jobs.size(); ++i) {
    ASSERT_NE(service.job(i), nullptr);
    EXPECT_GT(service.job(i)->counts.scans, 0U) << "job " << i;
  }
}

TEST(Turns, RestartsCostLittle) {
  // Goal: if eight users take turns on two cores, at least 93% of the cores' time is in committed
  // scans. Method: simulate one hour, and compare the core-seconds of committed scans with all
  // core-seconds.
  Scenario scenario = quiet_machine(2, 3600);
  for (std::uint32_t user = 1; user <= 8; ++user)
    scenario.jobs.push_back(job_of(UserId{user}, 0, k_endless_core_s));
  Service service(scenario);
  const Outcome outcome = service.run(0);
  EXPECT_EQ(outcome.violation, "");
  const double kept = outcome.useful_core_s / (2 * 3600.0);
  fmt::print("{:.1f}% of two cores' time is in kept scans, {} launches\n", 100 * kept,
             outcome.launches);
  EXPECT_GT(kept, 0.93);
}

TEST(Turns, CoresThatNobodyWantsAreUsedWhereItIsWorthIt) {
  // Goal: if a job has few cores and no other jobs are left, it is restarted on all cores if the
  // restart pays off. Method: let two users share four cores. When Bob's job ends, Ann's long job
  // must restart. In a second scenario, Ann's short job must not restart.
  Scenario scenario = quiet_machine(4, 0);
  scenario.jobs = {job_of(k_ann, 0, 2000), job_of(k_bob, 0, 100)};
  Service service(scenario);
  std::uint32_t cores = 0;
  service.at(45, [&] { cores = service.job(0)->cores; });
  std::uint32_t cores_later = 0;
  service.at(120, [&] { cores_later = service.job(0)->cores; });
  EXPECT_EQ(service.run(2000).violation, "");
  EXPECT_EQ(cores, 2U);
  EXPECT_EQ(cores_later, 4U);
  // Ann's job has three attempts: on all cores, on half of them while Bob's job runs, and on all
  // cores again.
  EXPECT_EQ(service.job(0)->attempt.value, 3U);

  Scenario brief = quiet_machine(4, 0);
  brief.jobs = {job_of(k_ann, 1, 28), job_of(k_bob, 0, 10)};
  brief.jobs[0].begin_s = 0.6;
  brief.jobs[1].wishes.cores = 2;
  Service short_service(brief);
  std::uint32_t cores_beside = 0;
  short_service.at(3, [&] { cores_beside = short_service.job(0)->cores; });
  EXPECT_EQ(short_service.run(2000).violation, "");
  EXPECT_EQ(cores_beside, 2U);
  EXPECT_EQ(short_service.job(0)->attempt.value, 1U);
}

/// Processor time of this process.
double used_s() {
  return static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
}

TEST(Turns, TenThousandJobsCostLittle) {
  // Goal: if 10,000 jobs wait and each running job sends two reports per second, the state machine
  // of jobs uses under 0.5% of a core. Submitting a job takes under 1 ms. Finding a job's place in
  // the queue also takes under 1 ms. Method: measure this process's processor time while the state
  // machine runs alone for ten simulated minutes.
  Options options;
  options.slice_s_min = 1e6;  // no job makes room, so others only wait
  Jobs machine(options);
  machine.step(Tick{.now_s = 0, .wall = 1e9});
  machine.step(Began{});
  machine.step(Room{.cores = 8, .memory_bytes = 1, .disk_free_bytes = 1});
  const double begin_s = used_s();
  constexpr std::uint64_t k_jobs = 10'000;
  for (std::uint64_t i = 0; i < k_jobs; ++i)
    machine.step(Submit{.token = i,
                        .user = UserId{static_cast<std::uint32_t>(i % 20)},
                        .client_key = fmt::format("{}", i),
                        .wishes = {.cores = 1}});
  const double submit_s = (used_s() - begin_s) / k_jobs;

  const double idle_from_s = used_s();
  constexpr double k_span_s = 600;
  double now_s = 0;
  std::uint64_t scans = 1;
  while (now_s < k_span_s) {
    now_s += 0.5;
    machine.step(Tick{.now_s = now_s, .wall = 1e9 + now_s});
    for (std::uint64_t job = 1; job <= 8; ++job)
      machine.step(Sight{
          .job = JobId{job}, .attempt = Attempt{1}, .seen = Running{.counts = {.scans = scans}}});
    ++scans;
  }
  const double idle = (used_s() - idle_from_s) / k_span_s;

  const double place_from_s = used_s();
  std::uint64_t places = 0;
  for (std::uint64_t i = 100; i < 5100; ++i)
    places += machine.waiting(JobId{i}).place;
  const double place_s = (used_s() - place_from_s) / 5000;
  fmt::print("a submit {:.1f} us, idle {:.3f}% of a core, a place in the queue {:.1f} us\n",
             1e6 * submit_s, 100 * idle, 1e6 * place_s);
  EXPECT_EQ(machine.standing().queued, k_jobs - 8);
  EXPECT_GT(places, 5000U);
  EXPECT_LT(idle, 0.005);
  EXPECT_LT(submit_s, 1e-3);
  EXPECT_LT(place_s, 1e-3);
}

}  // namespace
}  // namespace sleight::jobs::simulated
