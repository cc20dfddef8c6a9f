// The programs' worlds for tests of failures: one, which is called ball_2d and takes its requests.
#include "clients/cli/main_worlds.h"
#include "tests/failing/failing_ball.h"
#include "worker/run/world_entry.h"
#include "worker/worlds/ball_2d/request.h"
#include "worker/worlds/readers/ball_2d_reader.h"

namespace sleight::programs {

run::Catalogue worlds_of_program() {
  namespace ball_2d = worlds::ball_2d;
  using Entry = run::EntryOf<failing::FailingBall, ball_2d::Parameters, &ball_2d::request_binding,
                             &ball_2d::make_state_reader>;
  std::vector<run::Catalogue::Named> worlds;
  worlds.push_back({"ball_2d", std::make_unique<Entry>()});
  return run::Catalogue(std::move(worlds));
}

}  // namespace sleight::programs
