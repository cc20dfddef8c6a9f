#include "clients/cli/main_worlds.h"

namespace sleight::programs {

run::Catalogue worlds_of_program() {
  return run::Catalogue();
}

}  // namespace sleight::programs
