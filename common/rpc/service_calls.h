// The interfaces of service.capnp on a Handler: decodes, checks, asks, answers and audits. A
// table in the source says of each call which scope a token needs and whether it is audited.
//
// Thread safety: all on the loop's thread.
#pragma once

#include <service.capnp.h>

#include <cstddef>
#include <functional>
#include <memory>
#include <string>

#include "common/rpc/handler.h"
#include "common/rpc/server.h"
#include "common/rpc/watchers.h"

namespace sleight::rpc {

/// What the calls of all connections have in common. A call may outlive the server: then there is
/// no handler any more.
struct Calls {
  Handler* handler = nullptr;
  Watchers* watchers = nullptr;
  ServerLimits limits{};
  std::function<void(const std::string&)> complain{};
  Audit audit{};
  std::function<std::size_t()> connections{};
  Authority* authority = nullptr;  ///< none: nobody comes over TCP
  std::uint64_t count = 0;         ///< of all time
};

/// What the calls of one connection have in common.
struct Conversation {
  Caller caller{};
  bool is_known = false;          ///< whose it is; else only login is answered
  bool has_tried = false;         ///< to log in: once
  bool has_failed = false;        ///< a wrong token was shown: the connection is to be ended
  std::function<void()> known{};  ///< called once, when it has become known
  std::size_t calls = 0;          ///< that are not answered
  std::size_t sources = 0;
};

/// The bootstrap interface of a connection.
generated::Entrance::Client make_entrance(std::shared_ptr<Calls> calls,
                                          std::shared_ptr<Conversation> conversation);

}  // namespace sleight::rpc
