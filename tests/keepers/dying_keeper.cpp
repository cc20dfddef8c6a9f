// A `sleight-keeper` that is killed at a chosen moment. SLEIGHT_KEEPER_DIES_AT names the moment
// (moments.h).
#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <string>

#include "service/keeper/main_keeper.h"

namespace {

class Dying final : public sleight::keeper::Moments {
 public:
  void reached(sleight::keeper::Moment moment) override {
    const char* chosen = std::getenv("SLEIGHT_KEEPER_DIES_AT");
    const auto name = sleight::keeper::k_moment_names.at(static_cast<std::size_t>(moment));
    if (chosen == nullptr || chosen != name) return;
    if (moment != sleight::keeper::Moment::in_child) {
      ::kill(::getpid(), SIGKILL);
    } else {
      // Kill the keeper before its child executes the program. The kernel then kills the child.
      ::kill(::getppid(), SIGKILL);
    }
    ::sleep(60);
  }
};

}  // namespace

int main(int argc, char** argv) {
  Dying moments;
  return sleight::programs::keeper_main(argc, argv, moments);
}
