// The worlds of the test programs: a failing ball and a made-up world. The failing ball uses the
// name and requests of ball_2d. Adding a world to a program takes one line of this list.
#include "clients/cli/main_worlds.h"
#include "tests/failing/failing_ball.h"
#include "tests/failing/pucks.h"
#include "worker/run/world_entry.h"
#include "worker/worlds/ball_2d/request.h"
#include "worker/worlds/readers/readers.h"

namespace sleight::programs {

run::Catalogue worlds_of_program() {
  namespace ball_2d = worlds::ball_2d;
  using Entry = run::EntryOf<failing::FailingBall, ball_2d::Parameters, &ball_2d::request_binding,
                             &ball_2d::make_state_reader>;
  using PucksEntry = run::EntryOf<failing::Pucks, failing::PuckParameters, &failing::pucks_binding,
                                  &failing::make_pucks_reader>;
  std::vector<std::unique_ptr<run::WorldEntry>> worlds;
  worlds.push_back(std::make_unique<Entry>());
  worlds.push_back(std::make_unique<PucksEntry>());
  return run::Catalogue(std::move(worlds));
}

}  // namespace sleight::programs
