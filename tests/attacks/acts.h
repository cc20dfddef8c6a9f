// Attacks on the Cap'n Proto interface: on the socket, and in TLS before and after a login. An
// episode uses one connection.
//
// An episode counts its attacks, and the attacks that have reached the server's decoder. An attack
// has reached the decoder if the server then answers or ends the connection. The server must answer
// each valid call, and must close a connection that its peer has ended. The episode reports
// anything else as trouble.
//
// Thread safety: an episode belongs to one thread. Several threads may share a Tally and a Trouble.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>

#include "common/access/server_address.h"
#include "tests/attacks/lines.h"
#include "tests/attacks/odd_values.h"

namespace sleight::attack {

/// The attacked service.
struct Target {
  std::string socket{};
  access::ServerAddress address{};
  std::string token{};
  TlsSettings tls{TLS1_3_VERSION};
  TlsSettings old_tls{TLS1_2_VERSION};
};

enum class Door : std::uint8_t {
  socket,
  stranger,  ///< within TLS, before a login
  session    ///< within TLS, after a login
};

struct Tally {
  std::atomic<std::uint64_t> attacks = 0;
  std::atomic<std::uint64_t> reached = 0;
  std::atomic<std::uint64_t> turned_away = 0;  ///< no room for the connection, so no attack
};

/// The first thing that went wrong.
class Trouble {
 public:
  void say(const std::string& words) {
    const std::lock_guard lock(mutex_);
    if (!words_) words_ = words;
    is_there_ = true;
  }
  bool is_there() const { return is_there_; }
  std::optional<std::string> words() const {
    const std::lock_guard lock(mutex_);
    return words_;
  }

 private:
  mutable std::mutex mutex_;
  std::optional<std::string> words_{};
  std::atomic<bool> is_there_ = false;
};

/// The inputs of an episode.
struct Scene {
  const Target& target;
  Door door;
  std::uint64_t episode;
  Dice& dice;
  Tally& tally;
  Trouble& trouble;
  std::string_view kind;  ///< its name

  void trouble_is(const std::string& words) const;
};

void calls(const Scene& scene);
void mutated_messages(const Scene& scene);
void protocol_messages(const Scene& scene);
void pipelined_calls(const Scene& scene);
void capabilities(const Scene& scene);
void pointers(const Scene& scene);
void broken_frames(const Scene& scene);
void cut_streams(const Scene& scene);
void unread_answers(const Scene& scene);
void noise(const Scene& scene);
/// Only for strangers.
void wrong_logins(const Scene& scene);

/// Reads until the server closes the connection, and counts the close. Reports trouble if the
/// server keeps the connection open.
void await_end(const Scene& scene, Line& line);

}  // namespace sleight::attack
