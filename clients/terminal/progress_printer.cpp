#include "clients/terminal/progress_printer.h"

#include <fmt/format.h>

#include <utility>

namespace sleight::terminal {

ProgressPrinter::ProgressPrinter(std::string name, std::FILE* stream, double plain_line_every_s)
    : name_(std::move(name)),
      stream_(stream),
      line_(stream),
      plain_line_every_s_(plain_line_every_s),
      plain_line_at_(std::chrono::steady_clock::now()) {}

void ProgressPrinter::show(const events::Progress& progress) {
  if (line_.can_renew()) {
    line_.show(events::progress_line(name_, progress));
    return;
  }
  // Report finds at once.
  const plan::Finds& finds = progress.finds;
  const bool has_found = finds.wanted > 0 && (finds.found >= finds.wanted || finds.gave_up);
  const bool is_news = has_found && !std::exchange(said_found_, has_found);
  // If another session of the run began, the elapsed time restarts at 0.
  if (progress.elapsed_s < shown_s_) shown_s_ = 0;
  if (!is_news && progress.elapsed_s - shown_s_ < plain_line_every_s_) return;
  shown_s_ = progress.elapsed_s;
  put_plain(events::progress_line(name_, progress));
}

void ProgressPrinter::say(const std::string& phase) {
  const std::string line = fmt::format("{}  {}", name_, phase);
  if (line_.can_renew()) {
    line_.show(line);
    return;
  }
  const std::chrono::duration<double> silence = std::chrono::steady_clock::now() - plain_line_at_;
  if (silence.count() >= plain_line_every_s_) put_plain(line);
}

void ProgressPrinter::put_plain(const std::string& line) {
  std::fputs((line + "\n").c_str(), stream_);
  plain_line_at_ = std::chrono::steady_clock::now();
}

}  // namespace sleight::terminal
