#include "common/archive/remembering_reader.h"

#include <gtest/gtest.h>

#include <map>
#include <stdexcept>

#include "common/archive/digest/digest.h"
#include "common/archive/format.h"
#include "common/archive/layout.h"
#include "tests/archive/memory_archive.h"
#include "tests/unit/common/archive/fake_world.h"

namespace sleight::archive {
namespace {

using namespace testing;

class CountingReader final : public FakeReader {
 public:
  Motion play(base::BytesView state) const override {
    ++plays_[base::Bytes(state.begin(), state.end())];
    if (key_of(state) % 2 != 0) return {.ends = PlaysOut::failed};
    return FakeReader::play(state);
  }
  std::size_t states() const { return plays_.size(); }
  std::size_t plays() const {
    std::size_t sum = 0;
    for (const auto& [state, count] : plays_)
      sum += count;
    return sum;
  }

 private:
  mutable std::map<base::Bytes, std::size_t> plays_;
};

class MapOfMotions final : public Motions {
 public:
  std::optional<Motion> find(base::BytesView state) override {
    const auto found = motions_.find(base::Bytes(state.begin(), state.end()));
    if (found == motions_.end()) return std::nullopt;
    return found->second;
  }
  void keep(base::BytesView state, const Motion& motion) override {
    motions_[base::Bytes(state.begin(), state.end())] = motion;
  }

 private:
  std::map<base::Bytes, Motion> motions_;
};

TEST(RememberingReader, SimulatesEachMotionOnce) {
  // Goal: if two archives of a run are written, each motion is simulated once, even a motion that
  // fails. The archives equal those of a plain reader. Method: count the simulations and compare
  // the digests. The plain reader must simulate some motions more than once.
  const FakeRunOptions options;
  const auto digest_by = [&](const StateReader& reader) {
    MemoryArchive archive;
    return write_digested(archive, [&](Sink& sink) {
      write_archive(FakeRun(options), reader, options_for(options), sink);
    });
  };
  const CountingReader plain;
  const std::string expected = digest_by(plain);
  EXPECT_GT(plain.plays(), plain.states());
  const CountingReader counted;
  MapOfMotions motions;
  const RememberingReader remembering(counted, motions);
  EXPECT_EQ(digest_by(remembering), expected);
  EXPECT_EQ(digest_by(remembering), expected);
  EXPECT_GT(counted.states(), 5U);
  EXPECT_EQ(counted.plays(), counted.states());
}

TEST(RememberingReader, CanBeStoppedBeforeAMotionOrAComparison) {
  // Goal: if the callback throws, the reader stops before it simulates a new motion or makes a
  // comparison. Motions in memory stay available.
  const FakeReader reader;
  MapOfMotions motions;
  bool is_stopped = false;
  const RememberingReader remembering(reader, motions, [&] {
    if (is_stopped) throw std::runtime_error("stopped");
  });
  const base::Bytes one = FakeReader::state_of(2);
  const base::Bytes other = FakeReader::state_of(4);
  (void)remembering.play(one);
  is_stopped = true;
  EXPECT_NO_THROW((void)remembering.play(one));  // in memory
  EXPECT_THROW((void)remembering.play(other), std::runtime_error);
  EXPECT_THROW((void)remembering.likeness(one), std::runtime_error);
  is_stopped = false;
  const std::vector<double> looks = remembering.likeness(one);
  EXPECT_EQ(looks, reader.likeness(one));
  EXPECT_EQ(remembering.likeness_distance(looks, reader.likeness(other)),
            reader.likeness_distance(looks, reader.likeness(other)));
  EXPECT_TRUE(remembering.is_unlike(looks, reader.likeness(other), 0));
  EXPECT_FALSE(remembering.is_unlike(looks, looks, 0));
  EXPECT_EQ(remembering.variables(one).size(), reader.variables(one).size());
  EXPECT_EQ(remembering.log_priors_of_throws(3), reader.log_priors_of_throws(3));
  EXPECT_EQ(&remembering.layout(), &reader.layout());
}

}  // namespace
}  // namespace sleight::archive
