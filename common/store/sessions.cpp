#include "common/store/sessions.h"

#include <fmt/format.h>

#include <utility>

#include "common/store/checksum.h"
#include "common/store/database.h"
#include "common/store/run_store.h"

namespace sleight::store {

std::vector<Session> sessions_of(const std::string& folder) {
  Database database(RunStore::database_path(folder), Access::read_only);
  Statement identity = database.prepare("SELECT value FROM run WHERE key='identity'");
  if (!identity.step()) refuse_damaged(database.path(), "it has no identity");
  const std::uint64_t salt = salt_of(identity.text(0));

  Statement select = database.prepare(
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
      refuse_damaged(database.path(), fmt::format("how session {} ended", session.epoch));
    }
    sessions.push_back(std::move(session));
  }
  return sessions;
}

}  // namespace sleight::store
