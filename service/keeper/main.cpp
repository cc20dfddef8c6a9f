// The main function of `sleight-keeper`. This program has none of the moments at which tests kill a
// keeper.
#include "service/keeper/main_keeper.h"

int main(int argc, char** argv) {
  sleight::keeper::Moments moments;
  return sleight::programs::keeper_main(argc, argv, moments);
}
