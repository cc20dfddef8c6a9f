// Services of other machines that this user has logged in to: a file each in
// $XDG_CONFIG_HOME/sleight/servers, for its owner alone, with the token and how the service is
// known.
//
// Thread safety: one process at a time writes a service's file; each is replaced in one step.
#pragma once

#include <string>

#include "common/rpc/client.h"

namespace sleight::service_client {

/// What a command calls: a socket's path, or "HOST:PORT" of a service that was logged in to. Throws
/// base::Error: usage where it was not, environment where its file can't be read, or others can
/// read it too.
rpc::ServicePlace place_of(const std::string& called);

/// Keeps it, and returns the file. Throws base::Error.
std::string remember(const rpc::RemoteService& service);

/// False: it was not known. Throws base::Error.
bool forget(const access::ServerAddress& address);

}  // namespace sleight::service_client
