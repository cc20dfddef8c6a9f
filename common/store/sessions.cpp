#include "common/store/sessions.h"

#include <fmt/format.h>

#include <string_view>
#include <utility>

#include "common/base/error.h"
#include "common/store/checksum.h"
#include "common/store/run_store.h"
#include "common/store/scan_rows.h"
#include "common/store/shared_database.h"

namespace sleight::store {

StoredRequest stored_request_of(const std::string& folder) {
  const std::shared_ptr<SharedDatabase> database = open_to_read(folder);
  const auto text = [&](std::string_view key) { return run_value(*database, key); };
  if (const std::string format = text("format_version"); format != std::to_string(k_store_format)) {
    throw base::Error(
        base::ExitCode::conflict,
        fmt::format("{}: the run store has format {}, but this program reads format {}",
                    database->path(), format, k_store_format));
  }
  return {.identity_text = text("identity"),
          .request_text = text("request"),
          .results_version = text("results_version"),
          .program_version = text("program_version")};
}

std::vector<Session> sessions_of(const std::string& folder) {
  const std::shared_ptr<SharedDatabase> database = open_to_read(folder);
  const std::uint64_t salt = salt_of(run_value(*database, "identity"));

  const SharedDatabase::Turn turn = database->turn();
  Statement select = turn->prepare(
      "SELECT epoch, program_version, scans_before, ended, checksum FROM session ORDER BY epoch");
  std::vector<Session> sessions;
  while (select.step()) {
    Session session{.epoch = static_cast<std::uint64_t>(select.integer(0)),
                    .program_version = select.text(1),
                    .scans_before = static_cast<std::uint64_t>(select.integer(2))};
    const std::string line = select.text(3);
    const SessionKey key{.salt = salt, .epoch = session.epoch};
    session.end = events::run_end_of(line);
    const bool is_sound =
        checksum_of(key, session.program_version, session.scans_before, line) == select.integer(4);
    if (!is_sound || session.end.has_value() == line.empty()) {
      refuse_damaged(database->path(), fmt::format("the end of session {}", session.epoch));
    }
    sessions.push_back(std::move(session));
  }
  return sessions;
}

}  // namespace sleight::store
