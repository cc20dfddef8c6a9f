#include "common/rpc/service_calls.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <kj/debug.h>

#include <algorithm>
#include <exception>
#include <optional>
#include <span>
#include <string_view>
#include <type_traits>
#include <utility>

#include "common/access/token_text.h"
#include "common/rpc/encoding.h"
#include "common/rpc/limits.h"

namespace sleight::rpc {
namespace {

template <class T>
using Answer = base::Result<T, Refusal>;
/// Wraps an Answer for promises, because GCC 12 considers a Result inside kj::Maybe uninitialised.
template <class T>
using Answered = std::unique_ptr<Answer<T>>;

std::optional<Refusal> check(Nothing& /*nothing*/) {
  return std::nullopt;
}

std::optional<Refusal> check(JobId& job) {
  return job.value == 0 ? std::optional(no_such_job()) : std::nullopt;
}

std::optional<Refusal> check(const std::string& id) {
  if (access::is_token_id(id)) return std::nullopt;
  return Refusal{.kind = RefusalKind::not_found,
                 .sentence = "There is no such token.",
                 .what_to_do = "`sleight token list` shows the existing tokens."};
}

// ------------------------------------------------------------------------------------------- rules

/// The scope that a call requires, and its name in the audit log.
struct Rule {
  /// Empty: no token suffices. Tokens are created, listed and revoked only over the Unix socket.
  std::optional<Scope> scope{};
  /// Name in the audit log. Empty: the call isn't audited. Calls that aren't audited are frequent,
  /// change nothing and deliver no file.
  std::string_view audited_as{};
};

constexpr Rule k_submit{Scope::submit, "submit"};
constexpr Rule k_list{Scope::read};
constexpr Rule k_status{Scope::read};
constexpr Rule k_watch{Scope::read};
constexpr Rule k_logs{Scope::read};
constexpr Rule k_change{Scope::manage, "change"};  // audited by its kind: "cancel"
constexpr Rule k_fetch{Scope::read, "fetch"};
constexpr Rule k_info{Scope::read};
constexpr Rule k_drain{Scope::operate, "drain"};
constexpr Rule k_stop{Scope::operate, "stop"};
constexpr Rule k_create_token{{}, "create_token"};
constexpr Rule k_list_tokens{{}, "list_tokens"};
constexpr Rule k_revoke_token{{}, "revoke_token"};

/// Returns a refusal if the caller's token does not allow the call.
std::optional<Refusal> beyond_token(const Rule& rule, const Caller& caller) {
  if (!rule.scope) {
    if (caller.token_id.empty()) return std::nullopt;
    return Refusal{.kind = RefusalKind::not_allowed,
                   .sentence = "Tokens can only be managed on the service's machine.",
                   .what_to_do = "Run `sleight token` there."};
  }
  if (caller.scopes.has(*rule.scope)) return std::nullopt;
  return Refusal{
      .kind = RefusalKind::not_allowed,
      .sentence = fmt::format("This token does not have the scope '{}'.", name_of(*rule.scope)),
      .what_to_do =
          fmt::format("Use a token that was created with `--scope {}`.", name_of(*rule.scope))};
}

template <class Ask>
AuditLine line_of(const Rule& rule, const Ask& ask) {
  AuditLine line{.call = std::string(rule.audited_as)};
  if constexpr (std::is_same_v<Ask, Submission>) {
    line.of = fmt::format("{} job{}", ask.jobs.size(), ask.jobs.size() == 1 ? "" : "s");
  } else if constexpr (std::is_same_v<Ask, ChangeAsk>) {
    line.call = name_of(ask.kind);
    line.of =
        ask.target.job ? fmt::format("{}", *ask.target.job) : fmt::format("g{}", *ask.target.group);
  } else if constexpr (std::is_same_v<Ask, FetchAsk>) {
    line.of = fmt::format("{}", ask.job);
  } else if constexpr (std::is_same_v<Ask, std::string>) {
    line.of = ask;
  }
  return line;
}

template <class T>
std::string made_of(const T& answer) {
  if constexpr (std::is_same_v<T, Submitted>) {
    constexpr std::size_t k_named_max = 20;
    const std::span<const JobId> jobs(answer.jobs);
    return fmt::format("{}{}", fmt::join(jobs.first(std::min(jobs.size(), k_named_max)), " "),
                       jobs.size() > k_named_max ? " ..." : "");
  } else if constexpr (std::is_same_v<T, TokenView>) {
    return fmt::format("token {} of user {}", answer.id, answer.user);
  } else {
    return {};
  }
}

template <class T>
Reply<T> audited(const Audit& audit, const Caller& caller, AuditLine line, Reply<T> reply) {
  auto owed = std::make_shared<Reply<T>>(std::move(reply));
  return Reply<T>([audit, caller, line = std::move(line), owed](Answer<T> answer) mutable {
    if (answer.ok()) {
      line.outcome = "done";
      line.made = made_of(answer.value());
    } else {
      line.outcome = fmt::format("{}: {}", name_of(answer.error().kind), answer.error().sentence);
    }
    audit(caller, line);
    owed->give(std::move(answer));
  });
}

// ------------------------------------------------------------------------------------------- calls

Refusal failed() {
  return {.kind = RefusalKind::bug,
          .sentence = "The call failed in the server.",
          .what_to_do = "See the server's log."};
}

Refusal unreadable() {
  return {.kind = RefusalKind::bad_request, .sentence = "The call is malformed.", .what_to_do = ""};
}

/// Counts a call until it is answered.
class Counted {
 public:
  explicit Counted(std::shared_ptr<Conversation> conversation)
      : conversation_(std::move(conversation)) {
    ++conversation_->calls;
  }
  ~Counted() {
    if (conversation_) --conversation_->calls;
  }
  Counted(Counted&&) noexcept = default;
  Counted& operator=(Counted&&) = delete;

 private:
  std::shared_ptr<Conversation> conversation_;
};

struct Serving {
  std::shared_ptr<Calls> calls;
  std::shared_ptr<Conversation> conversation;

  /// Returns a refusal if a call can't be accepted now.
  std::optional<Refusal> unwelcome() const {
    ++calls->count;
    if (calls->handler == nullptr) {
      return Refusal{.kind = RefusalKind::busy,
                     .sentence = "The server is shutting down.",
                     .what_to_do = "Try again after the server restarts."};
    }
    if (!conversation->is_known ||
        (calls->authority != nullptr && !conversation->caller.token_id.empty() &&
         !calls->authority->lets_go_on(conversation->caller))) {
      return Refusal{.kind = RefusalKind::not_allowed,
                     .sentence = "The token is no longer valid.",
                     .what_to_do = "Log in with a valid token: `sleight login`."};
    }
    if (conversation->calls >= calls->limits.calls_max) {
      return Refusal{.kind = RefusalKind::limit,
                     .sentence = fmt::format("A connection can have at most {} calls in progress.",
                                             calls->limits.calls_max),
                     .what_to_do = "Wait for answers, or connect again."};
    }
    return std::nullopt;
  }

  /// Calls `start` with a Reply, and returns a promise of the answer.
  template <class T, class Start>
  kj::Promise<Answered<T>> ask(const Start& start) const {
    auto owed = kj::newPromiseAndFulfiller<Answered<T>>();
    auto fulfiller =
        std::make_shared<kj::Own<kj::PromiseFulfiller<Answered<T>>>>(kj::mv(owed.fulfiller));
    try {
      start(Reply<T>([fulfiller](Answer<T> answer) {
        (*fulfiller)->fulfill(std::make_unique<Answer<T>>(std::move(answer)));
      }));
    } catch (const std::exception& error) {
      // The reply is now destroyed, which refuses the call. The client doesn't get the exception's
      // message.
      calls->complain(error.what());
    }
    return kj::mv(owed.promise);
  }

  /// Handles a call: decodes and checks its parameters, calls `start`, and writes the answer. If
  /// the caller's token does not allow the call by `rule`, refuses it. `write` may return the
  /// reason why the answer can't be written.
  template <class T, class Context, class Decode, class Start, class Write>
  kj::Promise<void> serve(const Rule& rule, Context context, const Decode& decode,
                          const Start& start, Write write) const {
    std::optional<Refusal> refused = unwelcome();
    std::optional<std::decay_t<decltype(decode(context.getParams()))>> asked;
    if (!refused) {
      try {
        asked = decode(context.getParams());
      } catch (const kj::Exception&) {
        refused = unreadable();
      }
    }
    context.releaseParams();
    if (!refused) refused = check(*asked);
    if (refused) {
      put(*refused, context.getResults().initRefusal());
      return kj::READY_NOW;
    }
    Counted counted(conversation);
    const auto begin = [&](Reply<T> reply) {
      const Caller& caller = conversation->caller;
      if (calls->audit && !rule.audited_as.empty())
        reply = audited(calls->audit, caller, line_of(rule, *asked), std::move(reply));
      if (auto beyond = beyond_token(rule, caller)) return reply.refuse(*std::move(beyond));
      start(std::move(*asked), std::move(reply));
    };
    return ask<T>(begin).then(
        [context, write = kj::mv(write), held = kj::mv(counted)](Answered<T> answer) mutable {
          std::optional<Refusal> wrong;
          if (!answer->ok()) {
            wrong = answer->error();
          } else if constexpr (std::is_void_v<decltype(write(std::move(*answer).value(),
                                                             context.getResults()))>) {
            write(std::move(*answer).value(), context.getResults());
          } else {
            wrong = write(std::move(*answer).value(), context.getResults());
          }
          if (wrong) put(*wrong, context.getResults().initRefusal());
        });
  }
};

// ------------------------------------------------------------------------------------------- files

class FileCalls final : public generated::File::Server {
 public:
  FileCalls(Serving serving, std::unique_ptr<Source> source)
      : serving_(std::move(serving)), source_(std::move(source)), size_(source_->view().size) {
    ++serving_.conversation->sources;
  }
  ~FileCalls() { --serving_.conversation->sources; }
  KJ_DISALLOW_COPY(FileCalls);

  kj::Promise<void> read(ReadContext context) override {
    const auto params = context.getParams();
    const std::uint64_t offset = params.getOffset();
    const std::uint32_t bytes = params.getBytes();
    std::optional<Refusal> refused = serving_.unwelcome();
    if (!refused && (bytes > k_piece_bytes_max || offset > size_ || bytes > size_ - offset)) {
      refused = Refusal{.kind = RefusalKind::bad_request,
                        .sentence = "The requested part is too large or outside the file.",
                        .what_to_do = ""};
    }
    if (refused) {
      put(*refused, context.getResults().initRefusal());
      return kj::READY_NOW;
    }
    Counted counted(serving_.conversation);
    return serving_
        .ask<base::Bytes>(
            [&](Reply<base::Bytes> reply) { source_->read(offset, bytes, std::move(reply)); })
        .then([context, bytes, held = kj::mv(counted)](Answered<base::Bytes> answer) mutable {
          if (answer->ok() && answer->value().size() == bytes) {
            context.getResults(capnp::MessageSize{bytes / 8 + 16, 0})
                .setPiece(as_data(answer->value()));
          } else {
            put(answer->ok() ? failed() : answer->error(), context.getResults().initRefusal());
          }
        });
  }

 private:
  Serving serving_;
  std::unique_ptr<Source> source_;
  std::uint64_t size_;
};

// ----------------------------------------------------------------------------------------- service

class ServiceCalls final : public generated::Service::Server {
 public:
  explicit ServiceCalls(Serving serving) : serving_(std::move(serving)) {}

  kj::Promise<void> submit(SubmitContext context) override {
    return serve(
        k_submit, context, [](auto params) { return get(params.getSubmission()); },
        &Handler::submit,
        [](const Submitted& submitted, auto results) { put(submitted, results.initSubmitted()); });
  }

  kj::Promise<void> list(ListContext context) override {
    return serve(
        k_list, context, [](auto params) { return get(params.getAsk()); }, &Handler::list,
        [](const JobPage& page, auto results) -> std::optional<Refusal> {
          if (page.jobs.size() > k_page_jobs_max) return failed();
          put(page, results.initPage());
          return std::nullopt;
        });
  }

  kj::Promise<void> status(StatusContext context) override {
    return serve(
        k_status, context, [](auto params) { return JobId{params.getJob()}; }, &Handler::status,
        [](const JobView& job, auto results) { put(job, results.initJob()); });
  }

  kj::Promise<void> watch(WatchContext context) override {
    context.allowCancellation();
    std::vector<WatchPoint> points;
    std::optional<Refusal> refused = serving_.unwelcome();
    if (!refused) {
      for (const auto point : context.getParams().getPoints()) {
        if (points.size() > k_watch_jobs_max) break;
        points.push_back(get(point));
      }
      refused = rpc::check(points);
    }
    context.releaseParams();
    if (refused) {
      put(*refused, context.getResults().initRefusal());
      return kj::READY_NOW;
    }
    auto write = [context](const Batches& batches) mutable {
      auto to = context.getResults().initBatches(static_cast<unsigned>(batches.size()));
      for (unsigned i = 0; i < to.size(); ++i)
        put(batches[i].first, batches[i].second, to[i]);
    };
    if (const auto beyond = beyond_token(k_watch, caller())) {
      Batches batches;
      for (const WatchPoint& point : points)
        batches.emplace_back(point.job, *beyond);
      write(batches);
      return kj::READY_NOW;
    }
    Counted counted(serving_.conversation);
    return serving_.calls->watchers->wait(caller(), std::move(points))
        .then([write, held = kj::mv(counted)](const Batches& batches) mutable { write(batches); });
  }

  kj::Promise<void> logs(LogsContext context) override {
    return serve(
        k_logs, context, [](auto params) { return get(params.getAsk()); }, &Handler::logs,
        [](const LogPiece& piece, auto results) -> std::optional<Refusal> {
          if (piece.text.size() > k_log_bytes_max) return failed();
          put(piece, results.initPiece());
          return std::nullopt;
        });
  }

  kj::Promise<void> change(ChangeContext context) override {
    return serve(
        k_change, context, [](auto params) { return get(params.getAsk()); }, &Handler::change,
        [](const std::vector<Touched>& touched, auto results) {
          put_all(touched, results.initTouched(static_cast<unsigned>(
                               std::min(touched.size(), k_submission_jobs_max))));
        });
  }

  kj::Promise<void> fetch(FetchContext context) override {
    return serve(
        k_fetch, context, [](auto params) { return get(params.getAsk()); }, &Handler::fetch,
        [serving = serving_](Fetched fetched, auto results) -> std::optional<Refusal> {
          const std::size_t count = fetched.files.size();
          if (count > k_fetch_files_max) return failed();
          for (const auto& file : fetched.files) {
            if (!is_file_name(file->view().name)) return failed();
          }
          if (serving.conversation->sources + count > serving.calls->limits.sources_max) {
            return Refusal{.kind = RefusalKind::limit,
                           .sentence = "This connection is fetching too many files.",
                           .what_to_do = "Close some files, or connect again."};
          }
          auto files = results.initFiles(static_cast<unsigned>(count));
          for (unsigned i = 0; i < count; ++i) {
            put(fetched.files[i]->view(), files[i]);
            files[i].setFile(kj::heap<FileCalls>(serving, std::move(fetched.files[i])));
          }
          results.setHasMore(fetched.has_more);
          return std::nullopt;
        });
  }

  kj::Promise<void> info(InfoContext context) override {
    return serve(k_info, context, &Handler::info,
                 [calls = serving_.calls](ServerView view, auto results) {
                   if (calls->handler != nullptr) {
                     view.connections = static_cast<std::uint32_t>(calls->connections());
                     view.watchers = static_cast<std::uint32_t>(calls->watchers->waiting());
                   }
                   put(view, results.initServer());
                 });
  }

  kj::Promise<void> drain(DrainContext context) override {
    return serve(k_drain, context, &Handler::drain, [](Nothing, auto) {});
  }

  kj::Promise<void> stop(StopContext context) override {
    return serve(k_stop, context, &Handler::stop, [](Nothing, auto) {});
  }

  kj::Promise<void> createToken(CreateTokenContext context) override {
    return serve(
        k_create_token, context, [](auto params) { return get(params.getAsk()); },
        &Handler::create_token,
        [](const TokenView& token, auto results) { put(token, results.initToken()); });
  }

  kj::Promise<void> listTokens(ListTokensContext context) override {
    return serve(
        k_list_tokens, context, &Handler::list_tokens,
        [](const std::vector<TokenView>& tokens, auto results) {
          put_all(tokens,
                  results.initTokens(static_cast<unsigned>(std::min(tokens.size(), k_tokens_max))));
        });
  }

  kj::Promise<void> revokeToken(RevokeTokenContext context) override {
    return serve(
        k_revoke_token, context, [](auto params) { return as_string(params.getId()); },
        &Handler::revoke_token,
        [](const TokenView& token, auto results) { put(token, results.initToken()); });
  }

 private:
  Handler& handler() const { return *serving_.calls->handler; }
  const Caller& caller() const { return serving_.conversation->caller; }

  template <class Context, class Decode, class Ask, class T, class Write>
  kj::Promise<void> serve(const Rule& rule, Context context, const Decode& decode,
                          void (Handler::*call)(const Caller&, Ask, Reply<T>), Write write) const {
    return serving_.serve<T>(
        rule, context, decode,
        [&](Ask asked, Reply<T> reply) {
          (handler().*call)(caller(), std::move(asked), std::move(reply));
        },
        kj::mv(write));
  }
  /// Handles a call without parameters.
  template <class Context, class T, class Write>
  kj::Promise<void> serve(const Rule& rule, Context context,
                          void (Handler::*call)(const Caller&, Reply<T>), Write write) const {
    return serving_.serve<T>(
        rule, context, [](auto) { return Nothing(); },
        [&](Nothing, Reply<T> reply) { (handler().*call)(caller(), std::move(reply)); },
        kj::mv(write));
  }

  Serving serving_;
};

class EntranceCalls final : public generated::Entrance::Server {
 public:
  explicit EntranceCalls(const Serving& serving)
      : serving_(serving), service_(kj::heap<ServiceCalls>(serving)) {}

  kj::Promise<void> open(OpenContext context) override {
    if (serving_.conversation->is_known) {
      context.getResults().setService(service_);
    } else {
      put(no_entrance("Connections from other machines require a token."),
          context.getResults().initRefusal());
    }
    return kj::READY_NOW;
  }

  kj::Promise<void> login(LoginContext context) override {
    Conversation& conversation = *serving_.conversation;
    Authority* authority = serving_.calls->authority;
    if (serving_.calls->handler == nullptr || authority == nullptr || conversation.is_known ||
        std::exchange(conversation.has_tried, true)) {
      put(no_entrance("This connection does not accept a token."),
          context.getResults().initRefusal());
      return kj::READY_NOW;
    }
    const auto text = context.getParams().getToken();
    // Check the size first: a stranger's text is copied only if it has a token's size.
    auto caller = text.size() == access::k_token_characters
                      ? authority->login(as_string(text), conversation.caller.address)
                      : base::Result<Caller, Refusal>(no_entrance("This token is not valid here."));
    context.releaseParams();
    if (!caller) {
      conversation.has_failed = true;
      put(caller.error(), context.getResults().initRefusal());
      return kj::READY_NOW;
    }
    conversation.caller = std::move(caller).value();
    conversation.is_known = true;
    if (conversation.known) conversation.known();
    context.getResults().setService(service_);
    return kj::READY_NOW;
  }

 private:
  static Refusal no_entrance(const char* sentence) {
    return {.kind = RefusalKind::not_allowed,
            .sentence = sentence,
            .what_to_do = "Create a token on the service's machine, then run `sleight login`."};
  }

  Serving serving_;
  generated::Service::Client service_;
};

}  // namespace

generated::Entrance::Client make_entrance(std::shared_ptr<Calls> calls,
                                          std::shared_ptr<Conversation> conversation) {
  return kj::heap<EntranceCalls>(Serving{std::move(calls), std::move(conversation)});
}

}  // namespace sleight::rpc
