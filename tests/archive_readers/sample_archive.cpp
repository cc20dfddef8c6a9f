// Writes an archive of the fake world, to test other programs that read archives. Optionally also
// writes the archive's tables as CSV. Usage: sleight-sample-archive OUT.h5 SCANS [CSV_FOLDER].
// Prints the archive's digest and the writing time in seconds.
#include <fmt/format.h>

#include <chrono>
#include <cstdlib>
#include <fstream>

#include "common/archive/csv.h"
#include "common/archive/hdf5/reader.h"
#include "common/archive/hdf5/writer.h"
#include "common/base/error.h"
#include "tests/unit/common/archive/fake_world.h"

namespace {

using namespace sleight;

int run(const std::string& path, std::uint64_t scans, const char* csv_folder) {
  base::PosixFileSystem files;
  const auto start = std::chrono::steady_clock::now();
  const std::string digest = archive::hdf5::write_file(
      path, files, archive::testing::filler({.chains = 4, .scans = scans, .thin = 10, .finds = 7}));
  const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - start;
  fmt::print("{} {:.2f}\n", digest, taken.count());
  if (csv_folder == nullptr) return 0;
  const auto source = archive::hdf5::open_file(path);
  for (const std::string& table : archive::csv_tables()) {
    std::ofstream out(fmt::format("{}/{}.csv", csv_folder, table));
    archive::export_csv(*source, table, out);
    if (!out.flush()) return 1;
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 3) {
    fmt::print(stderr, "usage: sleight-sample-archive OUT.h5 SCANS [CSV_FOLDER]\n");
    return 2;
  }
  try {
    return run(argv[1], std::strtoull(argv[2], nullptr, 10), argc > 3 ? argv[3] : nullptr);
  } catch (const sleight::base::Error& error) {
    fmt::print(stderr, "{}\n", error.what());
    return static_cast<int>(error.exit_code());
  }
}
