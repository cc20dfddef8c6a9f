#include "tests/unit/common/store/lease_world.h"

#include <fmt/format.h>

#include <algorithm>
#include <condition_variable>
#include <limits>
#include <map>
#include <memory>
#include <mutex>
#include <thread>
#include <utility>
#include <variant>
#include <vector>

#include "common/base/error.h"
#include "common/random/stream.h"
#include "common/store/lease.h"

namespace sleight::store::testing {
namespace {

constexpr double k_story_s = 900;
constexpr std::uint32_t k_processes = 4;
constexpr std::uint32_t k_machines = 3;
constexpr double k_old_list_s = 30;

/// Exception that ends a simulated process when it is killed or the simulation ends.
struct Killed {};

class World;

/// Passes control from thread to thread. (std::binary_semaphore yields before it sleeps, so it is
/// too slow on a busy machine.)
class Baton {
 public:
  void release() {
    {
      const std::scoped_lock lock(mutex_);
      is_here_ = true;
    }
    changed_.notify_one();
  }
  void acquire() {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return is_here_; });
    is_here_ = false;
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  bool is_here_ = false;
};

/// Runs simulated processes, one after another.
struct Contender final : base::Clock {
  explicit Contender(World& all, std::uint32_t id) : world(all), number(id) {}
  double now_s() const override;

  World& world;
  std::uint32_t number;
  std::uint32_t machine = 0;
  double rate = 1;
  double offset_s = 0;
  std::int64_t process = 0;  ///< 0: no process runs
  double wake_s = 0;
  double stood_still_s = 0;  ///< as a wrong clock counts it
  std::optional<double> stands_since_s{};
  double own_change_s = -1;  ///< last change of the folder by this process
  Lease* lease = nullptr;
  Baton go{};
  std::thread thread{};
};

class World {
 public:
  World(std::uint64_t seed, Mistake mistake)
      : mistake_(mistake), stream_({.seed = seed, .purpose = random::Purpose::prior}, 0) {
    for (std::uint32_t i = 0; i < k_processes; ++i) {
      Contender& one = *contenders_.emplace_back(std::make_unique<Contender>(*this, i));
      one.machine = i % k_machines;
      one.offset_s = 1e5 * uniform();
      one.rate = 0.9 + 0.2 * uniform();
      if (mistake == Mistake::clocks_too_different) one.rate = i % 2 == 0 ? 0.6 : 1.4;
      one.wake_s = 20 * uniform();
    }
  }

  LeaseStory run();

  void stand_still(Contender& one, double for_s);
  void pause(Contender& one);
  double uniform() { return stream_.uniform(); }
  bool happens(double probability) { return uniform() < probability; }
  std::vector<std::uint64_t> list(const Contender& one);

  using Inode = std::shared_ptr<std::string>;
  std::map<std::uint64_t, Inode> files;
  LeaseStory story;
  double now_s = 0;
  void changed(Contender& one) {
    one.own_change_s = now_s;
    lists_.emplace_back(now_s, names());
  }
  void lands_later(Inode inode, std::string text) {
    late_.push_back({now_s + 90 * uniform(), std::move(inode), std::move(text)});
  }
  bool runs(std::int64_t process) const {
    return std::ranges::any_of(contenders_,
                               [&](const auto& one) { return one->process == process; });
  }
  std::int64_t next_process() { return ++processes_; }
  Mistake mistake() const { return mistake_; }
  bool is_over() const { return now_s >= k_story_s || story.violation.has_value(); }

 private:
  void live(Contender& one);
  void hold(Contender& one, Lease& lease);
  void resume(Contender& one);
  void land_late_writes();
  void judge();
  std::vector<std::uint64_t> names() const {
    std::vector<std::uint64_t> all;
    for (const auto& [generation, inode] : files)
      all.push_back(generation);
    return all;
  }

  struct LateWrite {
    double at_s;
    Inode inode;
    std::string text;
  };

  Mistake mistake_;
  random::Stream stream_;
  std::vector<std::unique_ptr<Contender>> contenders_;
  std::vector<std::pair<double, std::vector<std::uint64_t>>> lists_{{-1, {}}};
  std::vector<LateWrite> late_;
  std::int64_t processes_ = 0;
  Baton back_{};
};

double Contender::now_s() const {
  double true_s = world.now_s;
  if (world.mistake() == Mistake::clock_stands_still)
    true_s = stands_since_s.value_or(true_s) - stood_still_s;
  return offset_s + rate * true_s;
}

class SimulatedFiles final : public LeaseFiles {
 public:
  SimulatedFiles(World& world, Contender& one) : world_(world), one_(one) {}

  std::vector<std::uint64_t> list() override {
    world_.pause(one_);
    std::vector<std::uint64_t> all = world_.list(one_);
    world_.pause(one_);
    return all;
  }
  std::optional<std::string> read(std::uint64_t generation) override {
    world_.pause(one_);
    std::optional<std::string> text;
    if (const auto found = world_.files.find(generation); found != world_.files.end())
      text = *found->second;
    world_.pause(one_);
    return text;
  }
  std::unique_ptr<Own> make(std::uint64_t generation, const std::string& text) override {
    world_.pause(one_);
    const bool is_there = world_.files.contains(generation);
    const bool is_made = !is_there || world_.mistake() == Mistake::breaks_the_lock;
    auto inode = std::make_shared<std::string>(text);
    if (is_made) {
      world_.files[generation] = inode;
      world_.changed(one_);
    }
    world_.pause(one_);
    if (world_.happens(0.01)) throw base::Error("the answer was lost");
    return is_made ? std::make_unique<OwnFile>(*this, std::move(inode)) : nullptr;
  }
  void remove(std::uint64_t generation) override {
    world_.pause(one_);
    if (world_.files.erase(generation) > 0) world_.changed(one_);
    world_.pause(one_);
  }
  bool is_gone(const LeaseHolder& holder) override {
    return is_known(holder) && !runs_here(holder);
  }
  bool is_here(const LeaseHolder& holder) override { return is_known(holder) && runs_here(holder); }

 private:
  class OwnFile final : public Own {
   public:
    OwnFile(SimulatedFiles& files, World::Inode inode)
        : world_(files.world_), one_(files.one_), inode_(std::move(inode)) {}
    void write(const std::string& text) override {
      world_.pause(one_);
      if (world_.happens(0.05)) {
        if (world_.happens(0.5)) world_.lands_later(inode_, text);
        throw base::Error("the disk failed");
      }
      *inode_ = text;
      world_.pause(one_);
    }

   private:
    World& world_;
    Contender& one_;
    World::Inode inode_;
  };

  bool is_known(const LeaseHolder& holder) const {
    return holder.machine == std::to_string(one_.machine) ||
           world_.mistake() == Mistake::takes_all_for_dead;
  }
  bool runs_here(const LeaseHolder& holder) const {
    return holder.machine == std::to_string(one_.machine) && world_.runs(holder.process);
  }

  World& world_;
  Contender& one_;
};

std::vector<std::uint64_t> World::list(const Contender& one) {
  const bool knows_own = mistake_ != Mistake::believes_old_lists;
  if (!happens(knows_own ? 0.3 : 0.8)) return names();
  // Return an older list. The list must include this process's last change.
  double since_s = now_s - k_old_list_s * uniform();
  if (knows_own) since_s = std::max(since_s, one.own_change_s);
  std::vector<std::uint64_t> old;
  for (const auto& [at_s, names] : lists_) {
    if (at_s <= since_s) old = names;
  }
  return old;
}

void World::stand_still(Contender& one, double for_s) {
  one.wake_s = now_s + for_s;
  back_.release();
  one.go.acquire();
  if (is_over()) throw Killed();
}

/// Lets the process pause. Most pauses are short and some are long; a few never end.
void World::pause(Contender& one) {
  if (happens(0.004)) throw Killed();
  const double kind = uniform();
  if (kind > 0.02) {
    stand_still(one, kind > 0.12 ? 0.02 * uniform() : 4 * uniform());
    return;
  }
  one.stands_since_s = now_s;
  const double begin_s = now_s;
  stand_still(one, 2.5 * k_lease_s * uniform());
  one.stands_since_s.reset();
  one.stood_still_s += now_s - begin_s;
}

/// Runs one process. The process takes the lock, holds it for a while, and ends. Some processes end
/// without releasing the lock.
void World::live(Contender& one) {
  SimulatedFiles disk(*this, one);
  LeaseText text{.holder = {.host = std::to_string(one.machine),
                            .machine = std::to_string(one.machine),
                            .process = one.process},
                 .token = std::to_string(one.process)};
  Lease lease(disk, one, text);
  one.lease = &lease;
  while (true) {
    const Lease::Outcome outcome = lease.try_take();
    if (std::holds_alternative<Lease::Taken>(outcome)) break;
    if (std::holds_alternative<Lease::Held>(outcome)) {
      ++story.refused;
      return;
    }
    stand_still(one, 5 * uniform());
  }
  ++story.taken;
  if (lease.owes_copies()) ++story.taken_over;
  lease.set_copied();
  hold(one, lease);
}

void World::hold(Contender& one, Lease& lease) {
  const double end_s = now_s + 200 * uniform();
  while (now_s < end_s) {
    stand_still(one, lease.renew_every_s());
    bool may_go_on = true;
    try {
      may_go_on = lease.renew();
    } catch (const base::Error&) {
      may_go_on = lease.may_act();
    }
    if (!may_go_on) {
      ++story.lost;
      return;
    }
  }
  if (happens(0.5)) lease.release();
}

void World::resume(Contender& one) {
  if (!one.thread.joinable()) {
    one.thread = std::thread([this, &one] {
      one.go.acquire();
      while (!is_over()) {
        one.process = next_process();
        try {
          live(one);
        } catch (const Killed&) {
        } catch (const base::Error&) {
        }
        one.lease = nullptr;
        one.process = 0;
        one.stands_since_s.reset();
        try {
          if (!is_over()) stand_still(one, 20 * uniform());
        } catch (const Killed&) {
        }
      }
      one.wake_s = std::numeric_limits<double>::infinity();
      back_.release();
    });
  }
  one.go.release();
  back_.acquire();
}

void World::land_late_writes() {
  std::erase_if(late_, [&](const LateWrite& write) {
    if (write.at_s > now_s) return false;
    *write.inode = write.text;
    return true;
  });
}

void World::judge() {
  const auto acts = [](const auto& one) { return one->lease != nullptr && one->lease->may_act(); };
  if (std::ranges::count_if(contenders_, acts) < 2 || story.violation) return;
  story.violation = fmt::format("at {:.3f} s two may act:", now_s);
  for (const auto& one : contenders_) {
    if (acts(one)) *story.violation += fmt::format(" process {}", one->process);
  }
}

LeaseStory World::run() {
  while (true) {
    const auto next =
        std::ranges::min_element(contenders_, {}, [](const auto& one) { return one->wake_s; });
    Contender& one = **next;
    if (one.wake_s == std::numeric_limits<double>::infinity()) break;
    // At the end of the simulation, wake each process once so that it ends.
    now_s = std::max(now_s, one.wake_s);
    land_late_writes();
    judge();
    resume(one);
    judge();
  }
  for (const auto& one : contenders_) {
    if (one->thread.joinable()) one->thread.join();
  }
  return story;
}

}  // namespace

LeaseStory simulate_leases(std::uint64_t seed, Mistake mistake) {
  return World(seed, mistake).run();
}

}  // namespace sleight::store::testing
