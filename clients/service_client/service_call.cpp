#include "clients/service_client/service_call.h"

#include <fmt/format.h>

#include "clients/service_client/known_servers.h"
#include "clients/terminal/output.h"

namespace sleight::service_client {

base::ExitCode exit_code_of(rpc::RefusalKind kind) {
  switch (kind) {
    case rpc::RefusalKind::not_allowed:
      return base::ExitCode::not_allowed;
    case rpc::RefusalKind::bad_request:
      return base::ExitCode::bad_request;
    case rpc::RefusalKind::conflict:
      return base::ExitCode::conflict;
    case rpc::RefusalKind::not_found:
    case rpc::RefusalKind::gone:
      return base::ExitCode::usage;
    case rpc::RefusalKind::bug:
      return base::ExitCode::bug;
    case rpc::RefusalKind::unknown:
    case rpc::RefusalKind::limit:
    case rpc::RefusalKind::busy:
    case rpc::RefusalKind::environment:
      return base::ExitCode::environment;
  }
  return base::ExitCode::environment;
}

std::string words_of(const rpc::Refusal& refusal) {
  std::string words = terminal::shown(refusal.sentence);
  if (!refusal.what_to_do.empty()) words += fmt::format(" {}", terminal::shown(refusal.what_to_do));
  return words;
}

int with_service(const std::string& called, const std::function<int(rpc::Client&)>& work) {
  rpc::Client client(place_of(called));
  try {
    return work(client);
  } catch (const rpc::NoServer& error) {
    throw base::Error(base::ExitCode::no_server, terminal::shown(error.what()));
  } catch (const rpc::RefusedError& error) {
    const rpc::Refusal& refusal = error.refusal();
    throw base::Error(exit_code_of(refusal.kind), words_of(refusal));
  }
}

}  // namespace sleight::service_client
