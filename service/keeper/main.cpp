// `sleight-keeper`: main_keeper.h with a keeper that nothing kills.
#include "service/keeper/main_keeper.h"

int main(int argc, char** argv) {
  sleight::keeper::Moments moments;
  return sleight::programs::keeper_main(argc, argv, moments);
}
