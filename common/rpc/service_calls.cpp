#include "common/rpc/service_calls.h"

#include <fmt/format.h>
#include <kj/debug.h>

#include <algorithm>
#include <exception>
#include <optional>
#include <utility>

#include "common/access/token_text.h"
#include "common/rpc/encoding.h"
#include "common/rpc/limits.h"

namespace sleight::rpc {
namespace {

template <class T>
using Answer = base::Result<T, Refusal>;
/// As promises hold it: GCC 12 takes a Result inside kj::Maybe for uninitialised.
template <class T>
using Answered = std::unique_ptr<Answer<T>>;

std::optional<Refusal> check(Nothing& /*nothing*/) {
  return std::nullopt;
}

std::optional<Refusal> check(JobId& job) {
  return job.value == 0 ? std::optional(no_such_job()) : std::nullopt;
}

struct TokenId {
  std::string id{};
};

std::optional<Refusal> check(TokenId& token) {
  if (access::is_token_id(token.id)) return std::nullopt;
  return Refusal{.kind = RefusalKind::not_found,
                 .sentence = "There is no such token.",
                 .what_to_do = "`sleight token list` shows those that there are."};
}

Refusal failed() {
  return {.kind = RefusalKind::bug,
          .sentence = "The server failed at this call.",
          .what_to_do = "The server's log says more."};
}

Refusal unreadable() {
  return {
      .kind = RefusalKind::bad_request, .sentence = "The call can't be read.", .what_to_do = ""};
}

/// Counts a call for as long as it is unanswered.
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

/// What Service and File have in common.
struct Serving {
  std::shared_ptr<Calls> calls;
  std::shared_ptr<Conversation> conversation;

  /// Why a call is not taken, if it is not.
  std::optional<Refusal> unwelcome() const {
    ++calls->count;
    if (calls->handler == nullptr) {
      return Refusal{.kind = RefusalKind::busy,
                     .sentence = "The server is ending.",
                     .what_to_do = "Try again when it is started anew."};
    }
    if (!conversation->is_known ||
        (calls->authority != nullptr && !conversation->caller.token_id.empty() &&
         !calls->authority->lets_go_on(conversation->caller))) {
      return Refusal{.kind = RefusalKind::not_allowed,
                     .sentence = "The token is no longer valid.",
                     .what_to_do = "Log in with another one: `sleight login`."};
    }
    if (conversation->calls >= calls->limits.calls_max) {
      return Refusal{.kind = RefusalKind::limit,
                     .sentence = fmt::format("A connection has at most {} calls at once.",
                                             calls->limits.calls_max),
                     .what_to_do = "Wait for answers, or connect again."};
    }
    return std::nullopt;
  }

  /// Calls `start` with a Reply, and promises the answer.
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
      // The reply is refused as it is dropped; the words are for the log alone.
      calls->complain(error.what());
    }
    return kj::mv(owed.promise);
  }

  /// A whole call: `decode` its parameters, check them, `start` it, `write` its answer.
  template <class T, class Context, class Decode, class Start, class Write>
  kj::Promise<void> serve(Context context, const Decode& decode, const Start& start,
                          Write write) const {
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
    return ask<T>([&](Reply<T> reply) { start(std::move(*asked), std::move(reply)); })
        .then([context, write = kj::mv(write), held = kj::mv(counted)](Answered<T> answer) mutable {
          std::optional<Refusal> wrong;
          if (answer->ok()) {
            wrong = write(std::move(*answer).value(), context.getResults());
          } else {
            wrong = answer->error();
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
                        .sentence = "The piece is too large, or not within the file.",
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
    return serving_.serve<Submitted>(
        context, [](auto params) { return get(params.getSubmission()); },
        [this](Submission asked, Reply<Submitted> reply) {
          handler().submit(caller(), std::move(asked), std::move(reply));
        },
        [](const Submitted& submitted, auto results) {
          put(submitted, results.initSubmitted());
          return std::optional<Refusal>();
        });
  }

  kj::Promise<void> list(ListContext context) override {
    return serving_.serve<JobPage>(
        context, [](auto params) { return get(params.getAsk()); },
        [this](ListAsk asked, Reply<JobPage> reply) {
          handler().list(caller(), std::move(asked), std::move(reply));
        },
        [](const JobPage& page, auto results) -> std::optional<Refusal> {
          if (page.jobs.size() > k_page_jobs_max) return failed();
          put(page, results.initPage());
          return std::nullopt;
        });
  }

  kj::Promise<void> status(StatusContext context) override {
    return serving_.serve<JobView>(
        context, [](auto params) { return JobId{params.getJob()}; },
        [this](JobId job, Reply<JobView> reply) {
          handler().status(caller(), job, std::move(reply));
        },
        [](const JobView& job, auto results) {
          put(job, results.initJob(), Detail::full);
          return std::optional<Refusal>();
        });
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
    Counted counted(serving_.conversation);
    return serving_.calls->watchers->wait(caller(), std::move(points))
        .then([context, held = kj::mv(counted)](Batches batches) mutable {
          auto to = context.getResults().initBatches(static_cast<unsigned>(batches.size()));
          for (unsigned i = 0; i < to.size(); ++i)
            put(batches[i].first, batches[i].second, to[i]);
        });
  }

  kj::Promise<void> logs(LogsContext context) override {
    return serving_.serve<LogPiece>(
        context, [](auto params) { return get(params.getAsk()); },
        [this](LogAsk asked, Reply<LogPiece> reply) {
          handler().logs(caller(), asked, std::move(reply));
        },
        [](const LogPiece& piece, auto results) -> std::optional<Refusal> {
          if (piece.text.size() > k_log_bytes_max) return failed();
          put(piece, results.initPiece());
          return std::nullopt;
        });
  }

  kj::Promise<void> change(ChangeContext context) override {
    return serving_.serve<std::vector<Touched>>(
        context, [](auto params) { return get(params.getAsk()); },
        [this](const ChangeAsk& asked, Reply<std::vector<Touched>> reply) {
          handler().change(caller(), asked, std::move(reply));
        },
        [](const std::vector<Touched>& touched, auto results) {
          put(touched, results.initTouched(
                           static_cast<unsigned>(std::min(touched.size(), k_submission_jobs_max))));
          return std::optional<Refusal>();
        });
  }

  kj::Promise<void> fetch(FetchContext context) override {
    return serving_.serve<Fetched>(
        context, [](auto params) { return get(params.getAsk()); },
        [this](FetchAsk asked, Reply<Fetched> reply) {
          handler().fetch(caller(), std::move(asked), std::move(reply));
        },
        [serving = serving_](Fetched fetched, auto results) -> std::optional<Refusal> {
          const std::size_t count = fetched.files.size();
          if (count > k_fetch_files_max) return failed();
          for (const auto& file : fetched.files) {
            if (!is_file_name(file->view().name)) return failed();
          }
          if (serving.conversation->sources + count > serving.calls->limits.sources_max) {
            return Refusal{.kind = RefusalKind::limit,
                           .sentence = "This connection is fetching too many files.",
                           .what_to_do = "Let go of some, or connect again."};
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
    return serving_.serve<ServerView>(
        context, [](auto) { return Nothing(); },
        [this](Nothing, Reply<ServerView> reply) { handler().info(caller(), std::move(reply)); },
        [calls = serving_.calls](ServerView view, auto results) {
          if (calls->handler != nullptr) {
            view.connections = static_cast<std::uint32_t>(calls->connections());
            view.watchers = static_cast<std::uint32_t>(calls->watchers->waiting());
          }
          put(view, results.initServer());
          return std::optional<Refusal>();
        });
  }

  kj::Promise<void> drain(DrainContext context) override {
    return serving_.serve<Nothing>(
        context, [](auto) { return Nothing(); },
        [this](Nothing, Reply<Nothing> reply) { handler().drain(caller(), std::move(reply)); },
        [](Nothing, auto) { return std::optional<Refusal>(); });
  }

  kj::Promise<void> stop(StopContext context) override {
    return serving_.serve<Nothing>(
        context, [](auto) { return Nothing(); },
        [this](Nothing, Reply<Nothing> reply) { handler().stop(caller(), std::move(reply)); },
        [](Nothing, auto) { return std::optional<Refusal>(); });
  }

  kj::Promise<void> createToken(CreateTokenContext context) override {
    return serving_.serve<TokenView>(
        context, [](auto params) { return get(params.getAsk()); },
        [this](TokenAsk asked, Reply<TokenView> reply) {
          handler().create_token(caller(), std::move(asked), std::move(reply));
        },
        [](const TokenView& token, auto results) {
          put(token, results.initToken());
          return std::optional<Refusal>();
        });
  }

  kj::Promise<void> listTokens(ListTokensContext context) override {
    return serving_.serve<std::vector<TokenView>>(
        context, [](auto) { return Nothing(); },
        [this](Nothing, Reply<std::vector<TokenView>> reply) {
          handler().list_tokens(caller(), std::move(reply));
        },
        [](const std::vector<TokenView>& tokens, auto results) {
          auto to =
              results.initTokens(static_cast<unsigned>(std::min(tokens.size(), k_tokens_max)));
          for (unsigned i = 0; i < to.size(); ++i)
            put(tokens[i], to[i]);
          return std::optional<Refusal>();
        });
  }

  kj::Promise<void> revokeToken(RevokeTokenContext context) override {
    return serving_.serve<TokenView>(
        context, [](auto params) { return TokenId{as_string(params.getId())}; },
        [this](TokenId asked, Reply<TokenView> reply) {
          handler().revoke_token(caller(), std::move(asked.id), std::move(reply));
        },
        [](const TokenView& token, auto results) {
          put(token, results.initToken());
          return std::optional<Refusal>();
        });
  }

 private:
  Handler& handler() const { return *serving_.calls->handler; }
  const Caller& caller() const { return serving_.conversation->caller; }

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
      put(no_entrance("This way in takes a token."), context.getResults().initRefusal());
    }
    return kj::READY_NOW;
  }

  kj::Promise<void> login(LoginContext context) override {
    Conversation& conversation = *serving_.conversation;
    Authority* authority = serving_.calls->authority;
    if (serving_.calls->handler == nullptr || authority == nullptr || conversation.is_known ||
        std::exchange(conversation.has_tried, true)) {
      put(no_entrance("No token is taken here."), context.getResults().initRefusal());
      return kj::READY_NOW;
    }
    const auto text = context.getParams().getToken();
    // Its size is looked at first: nothing of what a stranger sends is copied.
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
            .what_to_do = "`sleight login` shows one that the service's machine has given out."};
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
