// Goal: each step of the lease protocol (common/store/lease.h) returns and writes the right state.
// Method: check examples with a manual clock.
#include "common/store/lease.h"

#include <gtest/gtest.h>

#include <map>
#include <memory>
#include <utility>

#include "common/base/error.h"

namespace sleight::store {
namespace {

/// A folder in memory. The only running process of machine "here" is `running`.
class Folder final : public LeaseFiles {
 public:
  std::vector<std::uint64_t> list() override {
    std::vector<std::uint64_t> all;
    for (const auto& [generation, text] : files)
      all.push_back(generation);
    return all;
  }
  std::optional<std::string> read(std::uint64_t generation) override {
    const auto found = files.find(generation);
    return found == files.end() ? std::nullopt : std::optional(*found->second);
  }
  std::unique_ptr<Own> make(std::uint64_t generation, const std::string& text) override {
    const auto [place, is_new] = files.try_emplace(generation, std::make_shared<std::string>(text));
    return is_new ? std::make_unique<OwnFile>(*this, place->second) : nullptr;
  }
  void remove(std::uint64_t generation) override { files.erase(generation); }
  bool is_gone(const LeaseHolder& holder) override {
    return holder.machine == "here" && holder.process != running;
  }
  bool is_here(const LeaseHolder& holder) override {
    return holder.machine == "here" && holder.process == running;
  }
  LeaseText newest() { return LeaseText::from_text(*files.rbegin()->second).value(); }

  std::map<std::uint64_t, std::shared_ptr<std::string>> files{};
  std::int64_t running = 0;
  bool fails = false;

 private:
  class OwnFile final : public Own {
   public:
    OwnFile(Folder& folder, std::shared_ptr<std::string> text)
        : folder_(folder), text_(std::move(text)) {}
    void write(const std::string& text) override {
      if (folder_.fails) throw base::Error("the disk failed");
      *text_ = text;
    }

   private:
    Folder& folder_;
    std::shared_ptr<std::string> text_;
  };
};

LeaseText of(const std::string& host, std::int64_t process) {
  return {.holder = {.host = host, .machine = host, .process = process, .since = "today"},
          .token = host + std::to_string(process)};
}

bool is_taken(const Lease::Outcome& outcome) {
  return std::holds_alternative<Lease::Taken>(outcome);
}

/// Returns how long the lease must still be observed. Returns nothing if the outcome isn't Unsure.
std::optional<double> left_s(const Lease::Outcome& outcome) {
  const auto* unsure = std::get_if<Lease::Unsure>(&outcome);
  return unsure == nullptr ? std::nullopt : std::optional(unsure->left_s);
}

std::string holder(const Lease::Outcome& outcome) {
  const auto* held = std::get_if<Lease::Held>(&outcome);
  return held == nullptr || !held->by ? "" : held->by->holder.host;
}

TEST(Lease, IsTakenAfterAWholeLeaseWithoutARenewal) {
  // Goal: if an observer sees no renewal for one lease duration by its own clock, it takes the
  // lease. If the observer sees a renewal, the holder is alive. Method: let several holders share
  // one manual clock.
  Folder folder;
  base::ManualClock clock;
  Lease first(folder, clock, of("a", 1));
  ASSERT_TRUE(is_taken(first.try_take()));
  Lease other(folder, clock, of("b", 2));
  EXPECT_EQ(left_s(other.try_take()), k_lease_s);
  clock.advance(k_lease_s - 1);
  EXPECT_EQ(left_s(other.try_take()), 1);
  clock.advance(1);
  EXPECT_TRUE(is_taken(other.try_take()));
  EXPECT_TRUE(other.owes_copies());
  EXPECT_FALSE(first.may_act());
  EXPECT_FALSE(first.renew());
  EXPECT_EQ(first.successor()->holder.host, "b");
  EXPECT_EQ(folder.list(), std::vector<std::uint64_t>{2});

  Lease third(folder, clock, of("c", 3));
  EXPECT_EQ(left_s(third.try_take()), k_lease_s);
  clock.advance(3);
  EXPECT_TRUE(other.renew());
  EXPECT_EQ(holder(third.try_take()), "b");
}

TEST(Lease, EndsForItsHolderBeforeOthersMayTakeIt) {
  // Goal: the holder may act for three quarters of a lease duration, counted from the start of its
  // last successful renewal. A disk failure doesn't prolong this time, and a short failure has no
  // effect. Method: advance a manual clock. Let the disk fail for a while.
  Folder folder;
  base::ManualClock clock;
  Lease lease(folder, clock, of("a", 1));
  ASSERT_TRUE(is_taken(lease.try_take()));
  clock.advance(40);
  EXPECT_TRUE(lease.renew());
  folder.fails = true;
  clock.advance(40);
  EXPECT_THROW((void)lease.renew(), base::Error);
  EXPECT_TRUE(lease.may_act());
  folder.fails = false;
  EXPECT_TRUE(lease.renew());
  clock.advance(0.75 * k_lease_s - 0.1);
  EXPECT_TRUE(lease.may_act());
  clock.advance(0.1);
  EXPECT_FALSE(lease.may_act());
  EXPECT_FALSE(lease.renew());
}

TEST(Lease, IsTakenAtOnceFromWhoeverIsGone) {
  // Goal: a lease is free at once if its holder released it or died on this machine. A holder that
  // runs on this machine keeps the lease without renewals.
  Folder folder;
  base::ManualClock clock;
  {
    Lease lease(folder, clock, of("a", 1));
    ASSERT_TRUE(is_taken(lease.try_take()));
    lease.set_epoch(7);
    ASSERT_TRUE(lease.renew());
    EXPECT_EQ(folder.newest().epoch, 7U);
    lease.release();
    EXPECT_FALSE(lease.may_act());
  }
  Lease here(folder, clock, of("here", 2));
  ASSERT_TRUE(is_taken(here.try_take()));
  EXPECT_FALSE(here.owes_copies());
  Lease second(folder, clock, of("here", 3));
  folder.running = 2;
  clock.advance(10 * k_lease_s);
  EXPECT_EQ(holder(second.try_take()), "here");
  folder.running = 3;
  ASSERT_TRUE(is_taken(second.try_take()));
  EXPECT_FALSE(second.owes_copies());
}

TEST(Lease, CopiesAreOwedUntilTheyAreMade) {
  // Goal: if a holder took the lease over from another machine but ended before it copied the
  // files, the next holder must copy them.
  Folder folder;
  base::ManualClock clock;
  Lease dead(folder, clock, of("a", 1));
  ASSERT_TRUE(is_taken(dead.try_take()));
  Lease heir(folder, clock, of("here", 2));
  (void)heir.try_take();
  clock.advance(k_lease_s);
  ASSERT_TRUE(is_taken(heir.try_take()));
  folder.running = 3;
  Lease next(folder, clock, of("here", 3));
  ASSERT_TRUE(is_taken(next.try_take()));
  EXPECT_TRUE(next.owes_copies());
  next.release();
  Lease last(folder, clock, of("c", 4));
  ASSERT_TRUE(is_taken(last.try_take()));
  EXPECT_TRUE(last.owes_copies());
  last.set_copied();
  last.release();
  Lease clean(folder, clock, of("d", 5));
  ASSERT_TRUE(is_taken(clean.try_take()));
  EXPECT_FALSE(clean.owes_copies());
}

TEST(Lease, TextComesBack) {
  // Goal: a lease's text has a fixed size and is read back with all fields. Control characters in a
  // host name are replaced, so that the text can't control a terminal. Method: write a lease whose
  // fields are all set. The host name has control characters.
  LeaseText lease = of("node\x1b[2J\n7", 123);
  lease.holder.started = 456;
  lease.epoch = 9;
  lease.beat = 1'000'000'000'000;
  lease.lease_s = 1.5;
  lease.is_released = true;
  lease.owes_copies = true;
  const std::string text = lease.to_text();
  EXPECT_EQ(text.size(), k_lease_text_bytes);
  const LeaseText back = LeaseText::from_text(text).value();
  EXPECT_EQ(back.holder.host, "node?[2J?7");
  EXPECT_EQ(back.holder.process, 123);
  EXPECT_EQ(back.holder.started, 456U);
  EXPECT_EQ(back.holder.since, "today");
  EXPECT_EQ(back.epoch, 9U);
  EXPECT_EQ(back.beat, 1'000'000'000'000U);
  EXPECT_EQ(back.lease_s, 1.5);
  EXPECT_TRUE(back.is_released);
  EXPECT_TRUE(back.owes_copies);
  EXPECT_EQ(back.to_text().size(), k_lease_text_bytes);
}

TEST(Lease, AStrangeFileIsAHolderThatSaysNothing) {
  // Goal: an invalid lease file delays a takeover by one lease duration, like the file of a dead
  // holder. Method: use an empty text, texts that are too short or too long, and texts whose
  // duration is invalid.
  const std::string sound = of("a", 1).to_text();
  std::string endless = sound;
  endless.replace(endless.find("lease_s 60"), 10, "lease_s 1e9");
  endless.resize(k_lease_text_bytes);
  std::string never = sound;
  never.replace(never.find("lease_s 60"), 10, "lease_s na");
  for (const std::string& text : {std::string(), std::string("x"), sound + "x", endless, never,
                                  std::string(k_lease_text_bytes, '\n')}) {
    EXPECT_FALSE(LeaseText::from_text(text)) << text;
    Folder folder;
    folder.files[4] = std::make_shared<std::string>(text);
    base::ManualClock clock;
    Lease lease(folder, clock, of("b", 2));
    EXPECT_EQ(left_s(lease.try_take()), k_lease_s);
    clock.advance(k_lease_s);
    EXPECT_TRUE(is_taken(lease.try_take()));
    EXPECT_TRUE(lease.owes_copies());
    EXPECT_EQ(folder.list(), std::vector<std::uint64_t>{5});
  }
}

}  // namespace
}  // namespace sleight::store
