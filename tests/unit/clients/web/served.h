// A server for tests. The server's handler answers with the text of the request.
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "clients/web/server.h"
#include "tests/unit/clients/web/raw_client.h"

namespace sleight::web::testing {

/// A gate that is closed at first. Opening the gate releases all waiting threads.
class Gate {
 public:
  void open() {
    const std::lock_guard lock(mutex_);
    is_open_ = true;
    changed_.notify_all();
  }
  void pass() {
    std::unique_lock lock(mutex_);
    ++waiting_;
    changed_.notify_all();
    changed_.wait(lock, [this] { return is_open_; });
  }
  void wait_for(int count) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return waiting_ >= count; });
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  bool is_open_ = false;
  int waiting_ = 0;
};

inline bool comes_true(const std::function<bool()>& is_so) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(k_wait_s);
  while (!is_so()) {
    if (std::chrono::steady_clock::now() > end) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  return true;
}

/// How long clients may take: an hour, so that tests pass on busy machines, or the server's own
/// limits.
enum class Patience : std::uint8_t { endless, of_limits };

class Served {
 public:
  explicit Served(ServerOptions options = {}, Patience patience = Patience::endless) {
    if (patience == Patience::endless) {
      constexpr double k_endless_s = 3600;
      options.limits.head_s_max = k_endless_s;
      options.limits.body_s_max = k_endless_s;
      options.limits.write_s_max = k_endless_s;
    }
    options.complain = [this](const std::string& words) {
      const std::lock_guard lock(mutex_);
      complaints_.push_back(words);
    };
    server_.emplace(std::move(options), [this](const Ask& ask) { return answer(ask); });
  }
  ~Served() { gate.open(); }

  Server& server() { return *server_; }
  std::uint16_t port() const { return server_->port(); }
  std::vector<std::string> complaints() {
    const std::lock_guard lock(mutex_);
    return complaints_;
  }
  int asks() const { return asks_; }

  Gate gate;  ///< answers to /slow wait here

 private:
  Answer answer(const Ask& ask) {
    ++asks_;
    if (ask.path == "/slow") gate.pass();
    if (ask.path == "/throws") throw std::runtime_error("secret words");
    if (ask.path == "/throws_odd") throw 7;
    if (ask.path == "/unsound") return {.fields = {{"X", "a\r\nSet-Cookie: b"}}};
    if (ask.path == "/large") return {.content = std::string(20U << 20U, 'x')};
    if (ask.path == "/missing") return error_answer(404, "There is no such thing.", "Look again.");
    std::string text = ask.method == Method::post ? "POST " : "GET ";
    text += ask.path;
    for (const Parameter& parameter : ask.parameters)
      text += " " + parameter.name + "=" + parameter.value;
    return {.type = "text/plain", .content = text + " " + ask.body, .etag = "\"e\""};
  }

  std::mutex mutex_;
  std::vector<std::string> complaints_;
  std::atomic<int> asks_ = 0;
  std::optional<Server> server_;  ///< last, because its threads use the members above
};

}  // namespace sleight::web::testing
