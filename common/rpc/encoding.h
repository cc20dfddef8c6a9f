// Converts between the values of service.h and the structs of service.capnp.
//
// `put` writes a value, and truncates texts and lists beyond their limits, so that an answer stays
// readable. `get` reads a value from an untrusted message. `get` throws kj::Exception if the
// message is malformed, and reads unknown enumeration values as `unknown`. limits.h checks
// requests.
//
// Thread safety: free functions.
#pragma once

#include <service.capnp.h>

#include <string>
#include <vector>

#include "common/rpc/handler.h"
#include "common/rpc/link.h"
#include "common/rpc/service.h"

namespace sleight::rpc {

void put(const Refusal& from, generated::Refusal::Builder to);
void put(const Submission& from, generated::Submission::Builder to);
void put(const Submitted& from, generated::Submitted::Builder to);
void put(const JobView& from, generated::JobView::Builder to);
void put(const ListAsk& from, generated::ListAsk::Builder to);
/// Writes the page's jobs. Omits their history, log and command, and truncates each text to a line.
void put(const JobPage& from, generated::JobPage::Builder to);
void put(const Touched& from, generated::Touched::Builder to);
void put(const ChangeAsk& from, generated::ChangeAsk::Builder to);
void put(const WatchPoint& from, generated::WatchPoint::Builder to);
void put(JobId job, const base::Result<Batch, Refusal>& from, generated::Batch::Builder to);
void put(const LogAsk& from, generated::LogAsk::Builder to);
void put(const LogPiece& from, generated::LogPiece::Builder to);
void put(const FetchAsk& from, generated::FetchAsk::Builder to);
void put(const FileView& from, generated::FileRef::Builder to);  ///< without the capability
void put(const ServerView& from, generated::ServerView::Builder to);
void put(const TokenAsk& from, generated::TokenAsk::Builder to);
void put(const TokenView& from, generated::TokenView::Builder to);

Refusal get(generated::Refusal::Reader from);
Submission get(generated::Submission::Reader from);
Submitted get(generated::Submitted::Reader from);
JobView get(generated::JobView::Reader from);
ListAsk get(generated::ListAsk::Reader from);
JobPage get(generated::JobPage::Reader from);
Touched get(generated::Touched::Reader from);
ChangeAsk get(generated::ChangeAsk::Reader from);
WatchPoint get(generated::WatchPoint::Reader from);
LogAsk get(generated::LogAsk::Reader from);
LogPiece get(generated::LogPiece::Reader from);
FetchAsk get(generated::FetchAsk::Reader from);
FileView get(generated::FileRef::Reader from);
ServerView get(generated::ServerView::Reader from);
TokenAsk get(generated::TokenAsk::Reader from);
TokenView get(generated::TokenView::Reader from);

ArrivedBatch get(generated::Batch::Reader from);

template <class T>
auto get_all(const T& list) {
  std::vector<decltype(get(*list.begin()))> values;
  for (const auto element : list)
    values.push_back(get(element));
  return values;
}

/// REQUIRES: `list` is no longer than `values`.
template <class T, class List>
void put_all(const std::vector<T>& values, List list) {
  for (unsigned i = 0; i < list.size(); ++i)
    put(values[i], list[i]);
}

capnp::Text::Reader as_text(const std::string& text);
std::string as_string(capnp::Text::Reader text);
kj::ArrayPtr<const kj::byte> as_data(base::BytesView bytes);

}  // namespace sleight::rpc
