// Serves the interfaces of service.capnp with a Handler: decodes, checks, forwards, answers and
// audits calls. A table in the source lists each call's required scope, and whether the call is
// audited.
//
// Thread safety: everything happens on the loop's thread.
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

/// State shared by the calls of all connections. A call may outlive the server. After the server's
/// end, `handler` is null.
struct Calls {
  Handler* handler = nullptr;
  Watchers* watchers = nullptr;
  ServerLimits limits{};
  std::function<void(const std::string&)> complain{};
  Audit audit{};
  std::function<std::size_t()> connections{};
  Authority* authority = nullptr;  ///< null: no TCP listener
  std::uint64_t count = 0;         ///< calls since the start
};

/// State shared by the calls of one connection.
struct Conversation {
  Caller caller{};
  bool is_known = false;          ///< if false, only login is answered
  bool has_tried = false;         ///< a login was tried; only one is allowed
  bool has_failed = false;        ///< a wrong token was shown; the connection must end
  std::function<void()> known{};  ///< called once, when is_known becomes true
  std::size_t calls = 0;          ///< unanswered calls
  std::size_t sources = 0;
};

/// Creates the bootstrap interface of a connection.
generated::Entrance::Client make_entrance(std::shared_ptr<Calls> calls,
                                          std::shared_ptr<Conversation> conversation);

}  // namespace sleight::rpc
