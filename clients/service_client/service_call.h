// A command's call of the service: which client, and what is said and returned when the call fails.
//
// Text that came from the service goes to the terminal through terminal::shown: the service may be
// another version, and other people name jobs.
#pragma once

#include <functional>
#include <string>

#include "common/base/error.h"
#include "common/rpc/client.h"

namespace sleight::service_client {

/// Runs `work`, a command, with the service at `called`: a socket's path, or HOST:PORT of one that
/// was logged in to (known_servers.h). A refusal becomes a base::Error with its exit code and
/// words, no server ExitCode::no_server, whose words say how to start one.
int with_service(const std::string& called, const std::function<int(rpc::Client&)>& work);

/// not_allowed 9, bad_request 3, conflict 4, not_found and gone 2, bug 1; all else 5.
base::ExitCode exit_code_of(rpc::RefusalKind kind);

/// Its sentence and what to do, on one line.
std::string words_of(const rpc::Refusal& refusal);

}  // namespace sleight::service_client
