// A listening TCP socket and the names of a connection's ends, as descriptors.
//
// Thread safety: free functions.
#pragma once

#include <string>

#include "common/access/server_address.h"
#include "common/base/descriptor.h"

namespace sleight::rpc {

/// Listens at a number or at a name's first address; port 0 takes any that is free. Non-blocking,
/// closed by exec. Throws base::Error: conflict where the port is taken, environment else.
base::Descriptor listen_at(const access::ServerAddress& address);

/// "192.0.2.7:50312", "[2001:db8::7]:50312"; "?" where the system doesn't say.
std::string peer_address_of(int descriptor);
/// Likewise, of its own end. Throws base::Error.
access::ServerAddress own_address_of(int descriptor);

/// Small messages at once, and peers that are gone are noticed within some minutes.
void tune(int descriptor);

}  // namespace sleight::rpc
