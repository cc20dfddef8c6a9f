// Tests of the scheduler, written as scripts (script.h).
#include "service/core/scheduler.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <string>

#include "tests/unit/service/core/script.h"

namespace sleight::core {
namespace {

/// Returns options with leases of 30 s. The scheduler asks a silent worker every 5 s.
SchedulerOptions blocks_ahead(std::uint32_t count) {
  SchedulerOptions options;
  options.blocks_ahead = count;
  return options;
}

TEST(Scheduler, GivesToTheLeastLoaded) {
  // Goal: until every thread has a block, the next block goes to the worker with the fewest
  // assignments per thread. Among equals, the worker with the lowest id gets the block. After a
  // worker has delivered, it gets up to two blocks per thread. Method: make ten blocks available at
  // once, then let three workers deliver.
  expect_goes("a b<a c<a d<a e<a f<a g<a h<a i<a j<a k<a", blocks_ahead(1), R"(join 3
  assign 3 #0 a@0+1 starts
join 1 threads=2
join 2
done 3 #0
  keep a@0+1
  assign 1 #1 b@0+1 starts
  assign 2 #2 c@0+1 starts
  assign 3 #3 d@0+1 starts
  assign 1 #4 e@0+1 starts
  assign 3 #5 f@0+1 starts
done 2 #2
  keep c@0+1
  assign 2 #6 g@0+1 starts
  assign 2 #7 h@0+1 starts
done 1 #1
  keep b@0+1
  assign 1 #8 i@0+1 starts
  assign 1 #9 j@0+1 starts
  assign 1 #10 k@0+1 starts
)");
}

TEST(Scheduler, SendsNothingAheadOfLongScans) {
  // Goal: while scans take longer than ahead_s_max, a worker has one block per thread. Otherwise it
  // has two. Method: let the cost of scans rise and fall.
  SchedulerOptions options = blocks_ahead(1);
  options.ahead_s_max = 0.1;
  expect_goes("a2 b2 c2 d2 e2 f9 g9 h9 i9 j9 k9", options, R"(join 1 threads=2
  assign 1 #0 a@0+2 starts
  assign 1 #1 b@0+2 starts
  assign 1 #2 c@0+2 starts
  assign 1 #3 d@0+2 starts
done 1 #0 cost=0.01
  keep a@0+2
  assign 1 #4 e@0+2 starts
done 1 #1 cost=2
  keep b@0+2
done 1 #2 cost=2
  keep c@0+2
done 1 #3 cost=0
  keep d@0+2
  assign 1 #5 f@0+9 starts
done 1 #4 cost=0
  keep e@0+2
  assign 1 #6 g@0+9 starts
done 1 #5 cost=0
  keep f@0+9
  assign 1 #7 h@0+9 starts
done 1 #6 cost=0
  keep g@0+9
  assign 1 #8 i@0+9 starts
done 1 #7 cost=0
  keep h@0+9
  assign 1 #9 j@0+9 starts
)");
}

TEST(Scheduler, SendsAStateOnceToWhoMadeIt) {
  // Goal: the scheduler sends a state's bytes to each worker except the worker that made the state.
  // If that worker has lost the state, it gets the bytes too. Method: move one replica between two
  // workers.
  expect_goes("a3 a2 a a", blocks_ahead(0), R"(join 1
  assign 1 #0 a@0+3 starts
join 2
done 1 #0
  keep a@0+3
  assign 1 #1 a@3+2 held
leave 1
  assign 2 #2 a@3+2 bytes
done 2 #2
  keep a@3+2
  assign 2 #3 a@5+1 held
done 2 #3 lacking
  assign 2 #4 a@5+1 bytes
done 2 #4
  keep a@5+1
  assign 2 #5 a@6+1 held
done 2 #5
  keep a@6+1
  (ended)
)");
}

TEST(Scheduler, GoesOnFromStoredStates) {
  // Goal: the first assignment of a resumed replica contains the bytes of the replica's stored
  // state. Method: resume two of three replicas.
  expect_goes("a b c a", blocks_ahead(0), R"(resume a 5
resume c 2
join 1 threads=3
  assign 1 #0 a@5+1 bytes
  assign 1 #1 b@0+1 starts
  assign 1 #2 c@2+1 bytes
done 1 #0
  keep a@5+1
  assign 1 #3 a@6+1 held
)");
}

TEST(Scheduler, GivesPartsOfLaddersToWhoHoldsMost) {
  // Goal: if a worker doesn't hold a state of a block, the block contains the state's bytes. Each
  // member of the block advances. Method: let two workers make the states of three replicas. Then
  // run the replicas as a ladder on one worker.
  expect_goes("a b c [abc] [abc]", blocks_ahead(0), R"(join 1
  assign 1 #0 a@0+1 starts
join 2 threads=2
  assign 2 #1 b@0+1 starts
  assign 2 #2 c@0+1 starts
done 2 #1
  keep b@0+1
done 1 #0
  keep a@0+1
done 2 #2
  keep c@0+1
  assign 1 #3 [a@1 held, b@1 bytes, c@1 bytes]
done 1 #3 scans=2
  keep a@1+2 b@1+2 c@1+2
  assign 1 #4 [a@3 held, b@3 held, c@3 held]
done 1 #4 scans=1
  keep a@3+1 b@3+1 c@3+1
  (ended)
)");
}

TEST(Scheduler, PrefersBlocksWhoseStatesAreHeld) {
  // Goal: a worker gets the waiting block whose states it holds, even if another block is older.
  // Method: the first worker holds the state of the second waiting block.
  expect_goes("a b c b<c a<c", blocks_ahead(0), R"(join 1
  assign 1 #0 a@0+1 starts
join 2
  assign 2 #1 b@0+1 starts
join 3
  assign 3 #2 c@0+1 starts
done 2 #1
  keep b@0+1
done 1 #0
  keep a@0+1
done 3 #2
  keep c@0+1
  assign 1 #3 a@1+1 held
  assign 2 #4 b@1+1 held
)");
}

TEST(Scheduler, PassesABlockOverABoundedNumberOfTimes) {
  // Goal: if no worker holds a block's states, the block is passed over at most k_passed_over_max
  // times, even if a returned block is before it in the queue. Method: keep two workers busy
  // forever. The third worker always has a next block of its own replica.
  std::string plan = "a x y z";
  std::string script = R"(join 1
  assign 1 #0 a@0+1 starts
join 2
  assign 2 #1 x@0+1 starts
join 3
  assign 3 #2 y@0+1 starts
)";
  std::uint32_t last = 0;
  for (std::uint32_t scan = 1; scan <= k_passed_over_max; ++scan) {
    plan += " a";
    script += fmt::format("done 1 #{}\n  keep a@{}+1\n  assign 1 #{} a@{}+1 held\n", last, scan - 1,
                          scan + 2, scan);
    last = scan + 2;
  }
  script +=
      fmt::format(R"(leave 2
done 1 #{}
  keep a@{}+1
  assign 1 #{} z@0+1 starts
done 1 #{}
  keep z@0+1
  assign 1 #{} a@{}+1 held
)",
                  last, k_passed_over_max, last + 1, last + 1, last + 2, k_passed_over_max + 1);
  expect_goes(plan + " a a", blocks_ahead(0), script);
}

TEST(Scheduler, TakesTheFirstResultOfABlock) {
  // Goal: when a lease ends, another worker also gets the block. The block's first result counts;
  // later results have no effect. Method: deliver the two workers' results in both orders.
  expect_goes("a b<a", blocks_ahead(0), R"(tick 0
join 1
  assign 1 #0 a@0+1 starts
join 2
tick 29.9
tick 30
  ask 1
  assign 2 #1 a@0+1 starts
done 1 #0
  keep a@0+1
  assign 1 #2 b@0+1 starts
done 2 #1
  (refused)
done 1 #0
  (refused)
done 1 #2
  keep b@0+1
  (ended)
)");
  expect_goes("a b<a", blocks_ahead(0), R"(tick 0
join 1
  assign 1 #0 a@0+1 starts
join 2
tick 30
  ask 1
  assign 2 #1 a@0+1 starts
done 2 #1
  keep a@0+1
  assign 2 #2 b@0+1 starts
done 1 #0
  (refused)
)");
  // The result arrives after its lease has ended, but no other worker has the block.
  expect_goes("a b<a", blocks_ahead(0), R"(tick 0
join 1
  assign 1 #0 a@0+1 starts
tick 31
  ask 1
done 1 #0
  keep a@0+1
  assign 1 #1 b@0+1 starts
)");
}

TEST(Scheduler, RefusesWhatDoesNotFit) {
  // Goal: a delivery of another epoch has no effect. A delivery is refused if its replica, scan,
  // number of members or number of scans is wrong. A refused delivery's block is assigned exactly
  // once more. Method: use a worker that has room for two assignments. If the block were assigned
  // twice, the script would show it.
  expect_goes("a2", blocks_ahead(1), R"(join 1
  assign 1 #0 a@0+2 starts
done 1 #0 epoch=2
  (refused)
done 1 #0 wrong=replica
  assign 1 #1 a@0+2 starts
  (refused)
done 1 #1 wrong=first
  assign 1 #2 a@0+2 starts
  (refused)
done 1 #2 wrong=members
  assign 1 #3 a@0+2 starts
  (refused)
done 1 #3 wrong=scans
  assign 1 #4 a@0+2 starts
  (refused)
done 1 #4 scans=1
  assign 1 #5 a@0+2 starts
  (refused)
done 1 #5 scans=0
  assign 1 #6 a@0+2 starts
  (refused)
done 1 #6
  keep a@0+2
  (ended)
)");
  // A ladder's block limits the scans of each member and their sum.
  expect_goes("[ab] [ab] [ab]", blocks_ahead(1), R"(join 1
  assign 1 #0 [a@0 starts, b@0 starts]
done 1 #0 scans=4
  assign 1 #1 [a@0 starts, b@0 starts]
  (refused)
done 1 #1 scans=0
  assign 1 #2 [a@0 starts, b@0 starts]
  (refused)
done 1 #2 scans=3
  keep a@0+3 b@0+3
  assign 1 #3 [a@3 held, b@3 held]
)");
  expect_goes("[ab]", blocks_ahead(1), R"(resume a 8
resume b 8
join 1
  assign 1 #0 [a@8 bytes, b@8 bytes]
done 1 #0 scans=3
  assign 1 #1 [a@8 bytes, b@8 bytes]
  (refused)
done 1 #1 scans=2
  keep a@8+2 b@8+2
  (ended)
)");
}

TEST(Scheduler, LeasesRunFromTheClocksBeginning) {
  // Goal: if a lease is granted before the first tick, it begins at the first tick. Method: the
  // first tick's time is far from 0.
  expect_goes("a", blocks_ahead(0), R"(join 1
  assign 1 #0 a@0+1 starts
tick 17000
tick 17029
tick 17030
  ask 1
tick 17035
  ask 1
)");
  expect_goes("a", blocks_ahead(0), R"(join 1
  assign 1 #0 a@0+1 starts
tick -400
tick -371
tick -370
  ask 1
)");
}

TEST(Scheduler, AsksTheSilentUntilTheyAnswer) {
  // Goal: if a worker's lease has ended, it gets nothing and is asked repeatedly for its
  // assignments. If the answer lacks an assignment, the assignment is made again. If the answer
  // lists an assignment, the assignment keeps its lease and isn't given to another worker. Method:
  // send an answer of another epoch; it must be ignored. Then send an answer that lists one of two
  // assignments.
  expect_goes("a b", blocks_ahead(1), R"(tick 0
join 1
  assign 1 #0 a@0+1 starts
  assign 1 #1 b@0+1 starts
tick 30
  ask 1
tick 34.9
tick 35
  ask 1
pong 1 #0 epoch=2
tick 40
  ask 1
pong 1 #0
  assign 1 #2 b@0+1 starts
join 2
tick 99.9
tick 100
  ask 1
  assign 2 #3 a@0+1 starts
)");
}

TEST(Scheduler, TakesAnAnswerForWhatWasBeforeTheQuestion) {
  // Goal: if an assignment was made after a question, it doesn't count as lost, although the answer
  // doesn't list it. Method: after the question, deliver a result, which causes a new assignment.
  // Then send the answer.
  expect_goes("a b<a", blocks_ahead(0), R"(tick 0
join 1
  assign 1 #0 a@0+1 starts
tick 30
  ask 1
done 1 #0
  keep a@0+1
  assign 1 #1 b@0+1 starts
pong 1
done 1 #1
  keep b@0+1
  (ended)
)");
}

TEST(Scheduler, AsksAgainForWhatItHeardNothingOf) {
  // Goal: if a silent worker sends a message that doesn't list its assignments, the worker is asked
  // again. Otherwise, lost assignments would take up its room forever. Method: lose the assignments
  // and the question. Then let the worker rejoin with the same incarnation, or deliver a result.
  expect_goes("a b", blocks_ahead(1), R"(tick 0
join 1
  assign 1 #0 a@0+1 starts
  assign 1 #1 b@0+1 starts
tick 30
  ask 1
join 1
tick 60
tick 90
  ask 1
pong 1
  assign 1 #2 a@0+1 starts
  assign 1 #3 b@0+1 starts
)");
  expect_goes("a b c", blocks_ahead(1), R"(tick 0
join 1
  assign 1 #0 a@0+1 starts
  assign 1 #1 b@0+1 starts
tick 30
  ask 1
done 1 #1
  keep b@0+1
  assign 1 #2 a@0+1 starts
tick 90
  ask 1
pong 1 #2
  assign 1 #3 c@0+1 starts
)");
}

TEST(Scheduler, KeepsLeasesOfCopiesApart) {
  // Goal: if two workers have the same block and one leaves, no third worker gets the block while
  // the lease of the other worker runs. Method: the first worker answers that it has the block.
  // Then the second worker leaves.
  expect_goes("a", blocks_ahead(0), R"(tick 0
join 1
  assign 1 #0 a@0+1 starts
join 2
tick 30
  ask 1
  assign 2 #1 a@0+1 starts
pong 1 #0
leave 2
join 3
tick 149
tick 150
  ask 1
  assign 3 #2 a@0+1 starts
leave 1
tick 269
tick 270
  ask 3
done 3 #2
  keep a@0+1
  (ended)
)");
}

TEST(Scheduler, GivesOnAllOfASilentWorkerInOrder) {
  // Goal: if a worker leaves or its leases end, other workers get all its blocks, the oldest first.
  // A silent worker is asked only once.
  expect_goes("a b c", blocks_ahead(0), R"(tick 0
join 1 threads=3
  assign 1 #0 a@0+1 starts
  assign 1 #1 b@0+1 starts
  assign 1 #2 c@0+1 starts
join 2 threads=3
tick 31
  ask 1
  assign 2 #3 a@0+1 starts
  assign 2 #4 b@0+1 starts
  assign 2 #5 c@0+1 starts
join 3 threads=3
leave 2
  assign 3 #6 a@0+1 starts
  assign 3 #7 b@0+1 starts
  assign 3 #8 c@0+1 starts
)");
}

TEST(Scheduler, ForgetsAnEarlierIncarnation) {
  // Goal: if a worker joins again with a new incarnation, its blocks are assigned again, its states
  // are sent as bytes, and its older results are refused. If a worker joins again with the same
  // incarnation, it loses nothing.
  expect_goes("a b a b", blocks_ahead(1), R"(join 1 incarnation=7
  assign 1 #0 a@0+1 starts
  assign 1 #1 b@0+1 starts
done 1 #0
  keep a@0+1
  assign 1 #2 a@1+1 held
join 1 incarnation=7
join 1 incarnation=8
  assign 1 #3 b@0+1 starts
  assign 1 #4 a@1+1 bytes
done 1 #2
  (refused)
done 1 #4
  keep a@1+1
done 1 #3
  keep b@0+1
  assign 1 #5 b@1+1 held
)");
}

TEST(Scheduler, StopsWhenAllCameBack) {
  // Goal: after a stop, the scheduler assigns nothing and keeps results that arrive in time. The
  // scheduler ends once all blocks have returned or their leases have ended. Method: stop at four
  // moments: before results arrive, before a lease ends, before invalid deliveries, and while no
  // block is assigned.
  expect_goes("a b c a", blocks_ahead(0), R"(join 1 threads=2
  assign 1 #0 a@0+1 starts
  assign 1 #1 b@0+1 starts
stop
join 2
done 1 #0
  keep a@0+1
done 1 #1
  keep b@0+1
  (ended)
)");
  expect_goes("a b c", blocks_ahead(0), R"(tick 0
join 1 threads=2
  assign 1 #0 a@0+1 starts
  assign 1 #1 b@0+1 starts
stop
done 1 #1
  keep b@0+1
tick 30
  ask 1
  (ended)
)");
  expect_goes("a b c", blocks_ahead(0), R"(resume a 3
join 1 threads=3
  assign 1 #0 a@3+1 bytes
  assign 1 #1 b@0+1 starts
  assign 1 #2 c@0+1 starts
stop
done 1 #0 lacking
done 1 #1 wrong=first
  (refused)
leave 1
  (ended)
)");
  expect_goes("a", blocks_ahead(0), "stop\n  (ended)\n");
}

TEST(Scheduler, ListensToNobodyItDoesNotKnow) {
  // Goal: if a worker is unknown, its answers and its departure have no effect. A result of an
  // unknown worker counts. If the worker joins later, it gets states as bytes.
  expect_goes("a a", blocks_ahead(0), R"(leave 4
pong 4 #0
join 1
  assign 1 #0 a@0+1 starts
leave 4
pong 4
done 4 #7 lacking
  (refused)
done 4 #0
  keep a@0+1
  assign 1 #1 a@1+1 bytes
leave 1
join 4
  assign 4 #2 a@1+1 bytes
)");
}

TEST(Scheduler, CountsWhatHappened) {
  // Goal: counts() counts kept results, copies of blocks, refused deliveries, and states that were
  // sent, held or missing.
  Script script("a2 a3 a", blocks_ahead(0));
  script.play(R"(join 1
done 1 #0
done 1 #1 lacking
done 1 #2
leave 1
join 2
done 2 #4 epoch=5
done 2 #4
)");
  const Counts& counts = script.counts();
  EXPECT_EQ(counts.blocks, 3U);
  EXPECT_EQ(counts.scans, 6U);
  EXPECT_EQ(counts.copies, 2U);
  EXPECT_EQ(counts.refused, 1U);
  EXPECT_EQ(counts.states_sent, 2U);
  EXPECT_EQ(counts.states_held, 2U);
  EXPECT_EQ(counts.states_missing, 1U);
}

}  // namespace
}  // namespace sleight::core
