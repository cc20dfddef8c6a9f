#include "clients/cli/logs_command.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <thread>
#include <utility>

#include "clients/cli/service_json.h"
#include "clients/service_client/selected_jobs.h"
#include "clients/service_client/service_call.h"
#include "clients/terminal/interruption.h"
#include "common/base/error.h"
#include "common/request/text.h"

namespace sleight::cli {
namespace {

/// Interval for reading a growing log.
constexpr std::chrono::milliseconds k_log_look_again{500};
/// Maximum failed reads before the command gives up on a missing server.
constexpr int k_looks_in_vain_max = 1200;

std::string fit(std::string_view line) {
  // A progress line is meant to be overwritten on a terminal. Here, print each state of the
  // progress line as a separate line.
  if (line.ends_with('\r')) line.remove_suffix(1);
  std::string text;
  for (const char c : line)
    text += c == '\t' ? std::string("    ") : std::string(1, c);
  return request::printable(text, LogLines::k_line_bytes_max) + "\n";
}

void print_piece(const rpc::LogPiece& piece, bool json, LogLines& lines) {
  if (json) {
    fmt::print("{}\n", on_one_line(to_json(piece)));
  } else {
    fmt::print("{}", lines.add(piece.text));
  }
  std::fflush(stdout);
}

/// Returns nothing while the server is away.
std::optional<rpc::LogPiece> next_piece(rpc::Client& client, const rpc::LogAsk& ask,
                                        int& looks_in_vain) {
  try {
    rpc::LogPiece piece = client.logs(ask);
    looks_in_vain = 0;
    return piece;
  } catch (const rpc::NoServer&) {
    if (++looks_in_vain > k_looks_in_vain_max) throw;
    if (looks_in_vain == 1) terminal::complain("lost the connection to the server, reconnecting");
    return std::nullopt;
  }
}

int follow(rpc::Client& client, rpc::LogAsk ask, rpc::LogPiece piece, const LogsOptions& options,
           LogLines& lines) {
  const terminal::Interruption interruption;
  int looks_in_vain = 0;
  while (!terminal::Interruption::requested()) {
    const std::uint64_t next = piece.first + piece.text.size();
    if (piece.is_over && next >= piece.end) return static_cast<int>(base::ExitCode::ok);
    if (next >= piece.end) std::this_thread::sleep_for(k_log_look_again);
    if (terminal::Interruption::requested()) break;
    ask.from = next;
    auto more = next_piece(client, ask, looks_in_vain);
    if (!more) {
      piece.end = next;  // makes the next read wait
      continue;
    }
    piece = *std::move(more);
    if (piece.first > next)
      terminal::complain(
          fmt::format("skipped {} bytes that the log no longer contains", piece.first - next));
    if (!piece.text.empty()) print_piece(piece, options.json, lines);
  }
  return static_cast<int>(base::ExitCode::interrupted);
}

}  // namespace

std::string LogLines::add(std::string_view bytes) {
  std::string text;
  open_ += bytes;
  std::size_t start = 0;
  while (true) {
    const std::size_t end = open_.find('\n', start);
    const std::size_t size = std::min(end, open_.size()) - start;
    if (size > k_line_bytes_max) {
      text += fit(std::string_view(open_).substr(start, k_line_bytes_max));
      start += k_line_bytes_max;
    } else if (end != std::string::npos) {
      text += fit(std::string_view(open_).substr(start, size));
      start = end + 1;
    } else {
      open_.erase(0, start);
      return text;
    }
  }
}

std::string LogLines::rest() {
  return open_.empty() ? std::string() : fit(std::exchange(open_, {}));
}

int show_logs(const std::string& socket, const LogsOptions& options) {
  const std::vector<service_client::JobName> names =
      service_client::read_job_names(std::span(&options.job, 1));
  const auto* job = std::get_if<rpc::JobId>(&names.front());
  if (job == nullptr) {
    throw base::Error(
        base::ExitCode::usage,
        "logs shows one job at a time; to list the jobs of a group, run `sleight list --group`");
  }
  return service_client::with_service(socket, [&](rpc::Client& client) {
    const rpc::LogAsk ask{.job = *job, .lines = options.lines, .bytes_max = rpc::k_log_bytes_max};
    LogLines lines;
    const rpc::LogPiece piece = client.logs(ask);
    print_piece(piece, options.json, lines);
    const int code = options.follow ? follow(client, ask, piece, options, lines)
                                    : static_cast<int>(base::ExitCode::ok);
    if (!options.json) fmt::print("{}", lines.rest());
    return code;
  });
}

}  // namespace sleight::cli
