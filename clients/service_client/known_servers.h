// Stores the services on other machines to which this user has logged in. Each service has a file
// in $XDG_CONFIG_HOME/sleight/servers with the token and the service's identity, readable only by
// its owner. Thread safety: one process at a time writes a service's file; each file is replaced
// atomically.
#pragma once

#include <string>

#include "common/rpc/client.h"

namespace sleight::service_client {

/// Returns how to reach a service: a socket's path, or "HOST:PORT" after a login. Throws
/// base::Error: usage without a login, environment if the file can't be read or others can read it
/// too.
rpc::ServicePlace place_of(const std::string& called);

/// Stores a service, and returns its file. Throws base::Error.
std::string remember(const rpc::RemoteService& service);

/// Returns false if the service was unknown. Throws base::Error.
bool forget(const access::ServerAddress& address);

}  // namespace sleight::service_client
