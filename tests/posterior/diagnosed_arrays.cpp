// Writes test arrays and their diagnostics by our code into a folder. Usage:
// sleight-diagnosed-arrays FOLDER SEED. For each array, writes a line `name chains draws` to
// arrays.txt. Writes the doubles to arrays.bin, little-endian and chain after chain. Writes lines
// `name measure value` to ours.txt; values are hexadecimal. Prints the time taken.
#include <fmt/format.h>
#include <fmt/os.h>

#include <bit>
#include <chrono>
#include <cstdlib>
#include <fstream>

#include "tests/posterior/arrays.h"
#include "worker/sampling/diagnostics/effective_sample_size.h"
#include "worker/sampling/diagnostics/r_hat.h"

namespace {

using namespace sleight;

std::string measures(const posterior::Array& array) {
  const sampling::Chains draws = array.draws.view();
  std::string lines;
  const auto add = [&](std::string_view measure, double value) {
    lines += fmt::format("{} {} {:a}\n", array.name, measure, value);
  };
  add("rhat", sampling::r_hat(draws));
  add("ess_bulk", sampling::ess_bulk(draws));
  add("ess_tail", sampling::ess_tail(draws));
  add("ess_mean", sampling::ess_mean(draws));
  add("mcse_mean", sampling::mcse_mean(draws));
  for (const double probability : {0.0, 0.05, 0.25, 0.5, 0.9, 1.0}) {
    add(fmt::format("ess_quantile_{}", probability), sampling::ess_quantile(draws, probability));
  }
  return lines;
}

}  // namespace

int main(int argc, char** argv) {
  static_assert(std::endian::native == std::endian::little, "arrays.bin is written as it lies");
  if (argc != 3) {
    fmt::print(stderr, "usage: sleight-diagnosed-arrays FOLDER SEED\n");
    return 2;
  }
  const std::string folder = argv[1];
  std::ofstream names(folder + "/arrays.txt");
  std::ofstream values(folder + "/arrays.bin", std::ios::binary);
  std::ofstream ours(folder + "/ours.txt");
  std::chrono::duration<double> taken{};
  for (const posterior::Array& array : posterior::arrays(std::strtoull(argv[2], nullptr, 10))) {
    names << fmt::format("{} {} {}\n", array.name, array.draws.chains, array.draws.draws);
    const std::vector<double>& doubles = array.draws.values;
    values.write(reinterpret_cast<const char*>(doubles.data()),
                 static_cast<std::streamsize>(doubles.size() * sizeof(double)));
    const auto start = std::chrono::steady_clock::now();
    ours << measures(array);
    taken += std::chrono::steady_clock::now() - start;
  }
  fmt::print("{:.2f}\n", taken.count());
  return names.flush() && values.flush() && ours.flush() ? 0 : 1;
}
