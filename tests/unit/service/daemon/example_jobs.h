// Example jobs for tests of the daemon.
#pragma once

#include <string>

#include "service/jobs/job.h"

namespace sleight::daemon::testing {

/// A job. No field has its default value, so a test notices if a record lacks a field.
inline jobs::Job full_job(std::uint64_t id) {
  jobs::Job job;
  job.id = jobs::JobId{id};
  job.user = jobs::UserId{1000};
  job.client_key = "key";
  job.content = "content";
  job.name = "a \"name\"\n";
  job.group = jobs::GroupId{3};
  job.priority = -4;
  job.wishes = {.cores = 5, .ranks = 6, .memory_bytes = 7};
  job.state = jobs::State::running;
  job.reason = jobs::Reason::began;
  job.words = "words";
  job.attempt = jobs::Attempt{9};
  job.core_seconds = 0.1 + 0.2;
  job.counts = {.scans = 1, .found = 2, .solutions = 3, .failures = {{"work_limit", 4}}};
  job.digest = "digest";
  job.remove_at_s = 12.5;
  job.submitted_wall = 1e9 + 1.0 / 3;
  job.pinned = true;
  job.revision = 2;
  return job;
}

}  // namespace sleight::daemon::testing
