#include "clients/service_client/fetched_archive.h"

#include <fmt/format.h>

#include <vector>

#include "clients/terminal/output.h"
#include "common/archive/digest/verify.h"
#include "common/archive/remote/remote_source.h"
#include "common/archive/summary.h"
#include "common/base/error.h"

namespace sleight::service_client {

void check_archive(const std::string& path, const rpc::JobView& job) {
  const auto findings_of = [&](const archive::Source& source) {
    std::vector<std::string> findings = archive::verify(source);
    if (findings.empty() && job.state == rpc::JobState::done && !job.digest.empty()) {
      // Use the stored digest, which has been verified.
      const std::string digest = archive::summary_of(source).content_digest;
      if (digest != job.digest)
        findings.push_back(fmt::format("the archive's digest is {}, expected the job's digest {}",
                                       digest, job.digest));
    }
    for (const std::string& finding : findings)
      terminal::complain(fmt::format("sleight: job {}: {}", job.id, terminal::shown(finding)));
    return findings;
  };
  std::string words;
  try {
    if (findings_of(*archive::remote::open_remote(path)).empty()) return;
  } catch (const base::Error& error) {
    if (error.exit_code() != base::ExitCode::bad_archive) throw;
    words = fmt::format(" ({})", error.what());
  }
  throw base::Error(
      base::ExitCode::bad_archive,
      fmt::format("job {}: the archive on the server's disk is damaged{}, so no file was written; "
                  "to rebuild the archive from the run store, run `sleight fetch {} --so-far`",
                  job.id, words, job.id));
}

}  // namespace sleight::service_client
