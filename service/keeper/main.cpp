// The main function of `sleight-keeper`, which dies at none of the moments for tests
// (main_keeper.h).
#include "service/keeper/main_keeper.h"

int main(int argc, char** argv) {
  sleight::keeper::Moments moments;
  return sleight::programs::keeper_main(argc, argv, moments);
}
