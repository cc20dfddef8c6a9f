#include "clients/terminal/progress_printer.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <string>

namespace sleight::terminal {
namespace {

TEST(ProgressPrinter, WritesPlainLinesNowAndThen) {
  // Goal: a log file gets a progress line every 5 s, without control characters. Method: report 20
  // s of progress to a file, once every 0.1 s, and count the lines.
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::tmpfile(), &std::fclose);
  ASSERT_NE(file, nullptr);
  ProgressPrinter printer("x", file.get());
  for (int i = 0; i <= 200; ++i)
    printer.show({.scans_done = static_cast<std::uint64_t>(i), .elapsed_s = 0.1 * i});
  printer.finish();
  std::rewind(file.get());
  std::string text(10'000, '\0');
  text.resize(std::fread(text.data(), 1, text.size(), file.get()));
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 4) << text;
  EXPECT_EQ(text.find('\x1b'), std::string::npos);
  EXPECT_EQ(text.find('\r'), std::string::npos);
}

TEST(ProgressPrinter, WritesPhasesThatLast) {
  // Goal: a message is written to a log file only if no line was written for a minimum time.
  // Method: print a message at once. Set the minimum time first to 0 s, then to its default.
  for (const double every_s : {0.0, k_plain_line_every_s}) {
    const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::tmpfile(), &std::fclose);
    ASSERT_NE(file, nullptr);
    ProgressPrinter printer("x", file.get(), every_s);
    printer.say("writing the archive: 1 of 2 draws (50%)");
    printer.finish();
    std::rewind(file.get());
    std::string text(10'000, '\0');
    text.resize(std::fread(text.data(), 1, text.size(), file.get()));
    EXPECT_EQ(text, every_s > 0 ? "" : "x  writing the archive: 1 of 2 draws (50%)\n");
  }
}

}  // namespace
}  // namespace sleight::terminal
