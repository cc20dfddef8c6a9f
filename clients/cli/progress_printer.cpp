#include "clients/cli/progress_printer.h"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <string_view>
#include <utility>

namespace sleight::cli {

ProgressPrinter::ProgressPrinter(std::string name, std::FILE* stream, double plain_line_every_s)
    : name_(std::move(name)),
      stream_(stream),
      plain_line_every_s_(plain_line_every_s),
      terminal_(::isatty(::fileno(stream)) == 1),
      plain_line_at_(std::chrono::steady_clock::now()) {}

void ProgressPrinter::show(const events::Progress& progress) {
  if (terminal_) {
    renew(events::progress_line(name_, progress));
    return;
  }
  // That something was found is said at once.
  const plan::Finds& finds = progress.finds;
  const bool has_found = finds.wanted > 0 && (finds.found >= finds.wanted || finds.gave_up);
  const bool is_news = has_found && !std::exchange(said_found_, has_found);
  // Another session of the run began: its time starts anew.
  if (progress.elapsed_s < shown_s_) shown_s_ = 0;
  if (!is_news && progress.elapsed_s - shown_s_ < plain_line_every_s_) return;
  shown_s_ = progress.elapsed_s;
  put_plain(events::progress_line(name_, progress));
}

void ProgressPrinter::say(const std::string& phase) {
  const std::string line = fmt::format("{}  {}", name_, phase);
  if (terminal_) {
    renew(line);
    return;
  }
  const std::chrono::duration<double> silence = std::chrono::steady_clock::now() - plain_line_at_;
  if (silence.count() >= plain_line_every_s_) put_plain(line);
}

void ProgressPrinter::put_plain(const std::string& line) {
  std::fputs((line + "\n").c_str(), stream_);
  plain_line_at_ = std::chrono::steady_clock::now();
}

void ProgressPrinter::renew(const std::string& line) {
  // A line that wraps can't be renewed: cut it to the terminal's width.
  winsize window{};
  const bool known = ::ioctl(::fileno(stream_), TIOCGWINSZ, &window) == 0 && window.ws_col > 1;
  const std::size_t width = known ? window.ws_col - 1U : 79U;
  // Carriage return, then clear to the end of the line.
  std::fputs(fmt::format("\r{}\x1b[K", std::string_view(line).substr(0, width)).c_str(), stream_);
  std::fflush(stream_);
  line_open_ = true;
}

void ProgressPrinter::clear() {
  if (!line_open_) return;
  std::fputs("\r\x1b[K", stream_);
  std::fflush(stream_);
  line_open_ = false;
}

void ProgressPrinter::finish() {
  if (line_open_) std::fputs("\n", stream_);
  line_open_ = false;
}

}  // namespace sleight::cli
