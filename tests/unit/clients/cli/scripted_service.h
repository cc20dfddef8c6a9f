// A service for tests of commands. It has a few scripted jobs and listens on a real socket. The
// loop and the server run in a separate thread. Each call is a function that a test may replace
// before it creates a client. By default, the calls `list`, `status` and `info` return data from
// `jobs`, and all other calls are refused.
#pragma once

#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <future>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "common/base/bytes.h"
#include "common/hash/sha256.h"
#include "common/rpc/handler.h"
#include "common/rpc/loop.h"
#include "common/rpc/server.h"

namespace sleight::cli {

class ScratchFolder {
 public:
  ScratchFolder() {
    std::string form = (std::filesystem::temp_directory_path() / "sleight-cli-XXXXXX").string();
    CHECK(::mkdtemp(form.data()) != nullptr);
    path_ = form;
  }
  ~ScratchFolder() { std::filesystem::remove_all(path_); }
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;
  std::string operator/(const std::string& name) const { return path_ + "/" + name; }

 private:
  std::string path_;
};

inline rpc::Refusal no_such_job(rpc::JobId job) {
  return {.kind = rpc::RefusalKind::not_found,
          .sentence = fmt::format("There is no job {}.", job),
          .what_to_do = "`sleight list` shows the jobs."};
}

class TextSource final : public rpc::Source {
 public:
  TextSource(std::string name, std::string text) : name_(std::move(name)), text_(std::move(text)) {}
  rpc::FileView view() const override {
    return {.name = name_, .size = text_.size(), .sha256 = hash::sha256_hex(text_)};
  }
  void read(std::uint64_t offset, std::size_t bytes, rpc::Reply<base::Bytes> reply) override {
    const auto view = std::as_bytes(std::span(text_)).subspan(offset, bytes);
    reply.answer(base::Bytes(view.begin(), view.end()));
  }

 private:
  std::string name_;
  std::string text_;
};

class ScriptedHandler final : public rpc::Handler {
 public:
  template <class... Arguments>
  using Call = std::function<void(Arguments...)>;

  std::vector<rpc::JobView> jobs;
  std::vector<rpc::TokenView> tokens;
  rpc::TokenAsk asked_token{};
  rpc::ServerView server{.version = "scripted", .pid = ::getpid()};
  Call<rpc::Submission, rpc::Reply<rpc::Submitted>> on_submit;
  Call<rpc::ListAsk, rpc::Reply<rpc::JobPage>> on_list;
  std::function<base::Result<rpc::Batch, rpc::Refusal>(const rpc::WatchPoint&)> on_events;
  Call<rpc::LogAsk, rpc::Reply<rpc::LogPiece>> on_logs;
  Call<rpc::ChangeAsk, rpc::Reply<std::vector<rpc::Touched>>> on_change;
  Call<rpc::FetchAsk, rpc::Reply<rpc::Fetched>> on_fetch;

  void submit(const rpc::Caller&, rpc::Submission submission,
              rpc::Reply<rpc::Submitted> reply) override {
    on_submit(std::move(submission), std::move(reply));
  }
  void list(const rpc::Caller&, rpc::ListAsk ask, rpc::Reply<rpc::JobPage> reply) override {
    if (on_list) return on_list(std::move(ask), std::move(reply));
    rpc::JobPage page;
    for (const rpc::JobView& job : jobs) {
      if (!ask.group || job.group == ask.group) page.jobs.push_back(job);
    }
    page.total = page.jobs.size();
    reply.answer(std::move(page));
  }
  void status(const rpc::Caller&, rpc::JobId id, rpc::Reply<rpc::JobView> reply) override {
    const auto job = std::ranges::find(jobs, id, &rpc::JobView::id);
    if (job == jobs.end()) return reply.refuse(no_such_job(id));
    reply.answer(*job);
  }
  base::Result<rpc::Batch, rpc::Refusal> events_after(const rpc::Caller&,
                                                      const rpc::WatchPoint& point,
                                                      std::size_t) override {
    if (on_events) return on_events(point);
    return no_such_job(point.job);
  }
  void logs(const rpc::Caller&, rpc::LogAsk ask, rpc::Reply<rpc::LogPiece> reply) override {
    on_logs(std::move(ask), std::move(reply));
  }
  void change(const rpc::Caller&, rpc::ChangeAsk ask,
              rpc::Reply<std::vector<rpc::Touched>> reply) override {
    on_change(ask, std::move(reply));
  }
  void fetch(const rpc::Caller&, rpc::FetchAsk ask, rpc::Reply<rpc::Fetched> reply) override {
    on_fetch(std::move(ask), std::move(reply));
  }
  void info(const rpc::Caller&, rpc::Reply<rpc::ServerView> reply) override {
    reply.answer(server);
  }
  void drain(const rpc::Caller&, rpc::Reply<rpc::Nothing> reply) override {
    server.draining = true;
    reply.answer({});
  }
  void stop(const rpc::Caller&, rpc::Reply<rpc::Nothing> reply) override { reply.answer({}); }
  void create_token(const rpc::Caller& caller, rpc::TokenAsk ask,
                    rpc::Reply<rpc::TokenView> reply) override {
    asked_token = ask;
    reply.answer({.id = ask.token.substr(8, 10),
                  .name = ask.name,
                  .user = ask.for_user.value_or(caller.user),
                  .scopes = ask.scopes,
                  .expires_s = ask.valid_s});
  }
  void list_tokens(const rpc::Caller&, rpc::Reply<std::vector<rpc::TokenView>> reply) override {
    reply.answer(std::vector<rpc::TokenView>(tokens));
  }
  void revoke_token(const rpc::Caller&, std::string id, rpc::Reply<rpc::TokenView> reply) override {
    for (const rpc::TokenView& token : tokens) {
      if (token.id != id) continue;
      rpc::TokenView revoked = token;
      revoked.revoked_s = 1;
      return reply.answer(std::move(revoked));
    }
    reply.refuse({.kind = rpc::RefusalKind::not_found, .sentence = "There is no such token."});
  }
};

/// Serves a handler at a path during its lifetime. Several servers may use the path one after
/// another.
class ServingThread {
 public:
  ServingThread(const std::string& path, ScriptedHandler& handler) {
    std::promise<void> listens;
    thread_ = std::thread([&, path] {
      rpc::Loop loop;
      rpc::Server server(loop, path, handler);
      loop_ = &loop;
      server_ = &server;
      listens.set_value();
      loop.run();
    });
    listens.get_future().wait();
  }
  ~ServingThread() {
    loop_->stop();
    thread_.join();
  }
  ServingThread(const ServingThread&) = delete;
  ServingThread& operator=(const ServingThread&) = delete;

  void post(std::function<void()> work) { loop_->post(std::move(work)); }
  void news(rpc::JobId job) {
    loop_->post([this, job] { server_->news(job); });
  }

 private:
  std::thread thread_;
  rpc::Loop* loop_ = nullptr;
  rpc::Server* server_ = nullptr;
};

}  // namespace sleight::cli
