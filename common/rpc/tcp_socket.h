// TCP sockets as descriptors. Makes listening sockets, and returns the addresses of a connection's
// ends.
//
// Thread safety: free functions.
#pragma once

#include <string>

#include "common/access/server_address.h"
#include "common/base/descriptor.h"

namespace sleight::rpc {

/// Listens at a numeric address, or at the first address of a host name. Port 0 chooses a free
/// port. The socket is non-blocking and closed by exec. If the port is in use, throws
/// base::Error(conflict). For other failures, throws base::Error(environment).
base::Descriptor listen_at(const access::ServerAddress& address);

/// Returns for example "192.0.2.7:50312" or "[2001:db8::7]:50312"; "?" if unknown.
std::string peer_address_of(int descriptor);
/// Returns the local end's address. Throws base::Error.
access::ServerAddress own_address_of(int descriptor);

/// Makes a socket send small messages at once, and detect dead peers within some minutes.
void tune(int descriptor);

}  // namespace sleight::rpc
