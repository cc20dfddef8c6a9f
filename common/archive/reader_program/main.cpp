// sleight-reader: reads one archive, which may be hostile, for the program that started it.
#include "common/archive/reader_program/program.h"

int main(int argc, char** argv) {
  return sleight::archive::reader_program::run_confined(
      argc, argv, &sleight::archive::reader_program::read_and_answer);
}
