// Calls the service for a command: chooses the client and reports failures.
//
// Text from the service is printed through terminal::shown, because the service may be another
// version, and other people choose names of jobs.
#pragma once

#include <functional>
#include <string>

#include "common/base/error.h"
#include "common/rpc/client.h"

namespace sleight::service_client {

/// Runs `work` with the service at `called`: a socket's path, or HOST:PORT after a login
/// (known_servers.h). A refusal becomes a base::Error with its exit code and text. A missing server
/// becomes ExitCode::no_server with advice on how to start one.
int with_service(const std::string& called, const std::function<int(rpc::Client&)>& work);

/// Returns the exit code of a refusal: 9 for not_allowed, 3 for bad_request, 4 for conflict, 2 for
/// not_found and gone, 1 for bug, 5 for others.
base::ExitCode exit_code_of(rpc::RefusalKind kind);

/// Returns the sentence and the advice on one line.
std::string words_of(const rpc::Refusal& refusal);

}  // namespace sleight::service_client
