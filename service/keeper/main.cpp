// `sleight-keeper` without moments at which it dies (main_keeper.h).
#include "service/keeper/main_keeper.h"

int main(int argc, char** argv) {
  sleight::keeper::Moments moments;
  return sleight::programs::keeper_main(argc, argv, moments);
}
