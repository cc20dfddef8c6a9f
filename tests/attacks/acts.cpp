#include "tests/attacks/acts.h"

#include <fmt/format.h>

#include <vector>

#include "tests/attacks/listener.h"
#include "tests/attacks/messages.h"

namespace sleight::attack {
namespace {

constexpr std::size_t k_message_bytes_max = 4U << 20U;    // for a user, from ServerLimits
constexpr std::size_t k_stranger_bytes_max = 16U << 10U;  // for a stranger
constexpr std::uint64_t k_opening_answers = 2;

class Talk {
 public:
  Talk(const Scene& scene, std::unique_ptr<Line> line) : scene_(scene), line_(std::move(line)) {}

  /// Reads available bytes. If no bytes are available, waits for the first bytes until the timeout.
  /// Returns false if no bytes came and the connection is still open.
  bool hear(int patience_ms = 0) {
    bool has_heard = false;
    std::string bytes;
    while (!has_ended_) {
      const Got got = line_->receive(bytes, patience_ms);
      if (got == Got::nothing) break;
      has_heard = true;
      has_ended_ = got == Got::ended;
      listener_.hear(bytes);
      bytes.clear();
      patience_ms = 0;
    }
    return has_heard || has_ended_;
  }
  bool send(std::string_view bytes) {
    if (has_ended_ || !line_->send(bytes)) return false;
    hear();
    return !has_ended_;
  }
  /// Ends the sending direction, and reads until the server closes the connection.
  void end() {
    line_->end_sending();
    while (!has_ended_) {
      if (!hear(k_patience_ms)) {
        scene_.trouble_is("the server keeps a connection whose peer has ended it");
        return;
      }
    }
    judge();
  }
  void judge() const {
    if (listener_.bugs() > 0) scene_.trouble_is("the server failed at a call: a refusal as bug");
    if (listener_.is_garbled()) scene_.trouble_is("the server's answers can't be read");
  }
  /// Returns how often the server reacted: by answers after the opening, and by closing the
  /// connection.
  std::uint64_t reached(bool ended_by_itself) const {
    const std::uint64_t heard = listener_.messages();
    return (heard > k_opening_answers ? heard - k_opening_answers : 0) + (ended_by_itself ? 1 : 0);
  }
  bool has_ended() const { return has_ended_; }
  const Listener& listener() const { return listener_; }
  Line& line() { return *line_; }

 private:
  const Scene& scene_;
  std::unique_ptr<Line> line_;
  Listener listener_{};
  bool has_ended_ = false;
};

Bounds bounds_of(const Scene& scene) {
  if (scene.door == Door::stranger)
    return {.text_bytes_max = scene.dice.one_in(20) ? 2 * k_stranger_bytes_max : 2000};
  return {.is_owner = scene.door == Door::socket};
}

/// Returns nothing if the server has no room for a connection.
std::optional<Talk> begin(const Scene& scene) {
  auto line = scene.door == Door::socket
                  ? line_to_socket(scene.target.socket)
                  : secured(line_to_port(scene.target.address, scene.episode), scene.target.tls);
  if (!line) {
    ++scene.tally.turned_away;
    return std::nullopt;
  }
  return std::optional<Talk>(std::in_place, scene, std::move(line));
}

std::string first_words(const Scene& scene) {
  return scene.door == Door::session ? login(scene.target.token) : opening();
}

std::optional<Talk> begin_opened(const Scene& scene) {
  auto talk = begin(scene);
  if (talk) talk->send(first_words(scene));
  return talk;
}

/// Sends messages from make() until the server closes the connection.
template <class Make>
void send_messages(const Scene& scene, std::uint64_t count, const Make& make) {
  auto talk = begin_opened(scene);
  if (!talk) return;
  std::uint64_t sent = 0;
  while (sent < count) {
    ++sent;
    if (!talk->send(make(static_cast<std::uint32_t>(k_first_question + sent)))) break;
  }
  const bool ended_by_itself = talk->has_ended();
  talk->end();
  scene.tally.attacks += sent;
  scene.tally.reached += talk->reached(ended_by_itself);
}

}  // namespace

void Scene::trouble_is(const std::string& words) const {
  trouble.say(fmt::format("{} (episode {}, {})", words, episode, kind));
}

// Goal: the server answers calls of every method, whatever the valid parameters are.
void calls(const Scene& scene) {
  auto talk = begin_opened(scene);
  if (!talk) return;
  const Bounds bounds = bounds_of(scene);
  const std::size_t bytes_max =
      scene.door == Door::stranger ? k_stranger_bytes_max : k_message_bytes_max;
  constexpr int k_windows = 8;
  constexpr std::uint32_t k_at_once = 12;  // the limit per connection is 16
  std::uint32_t question = k_first_question;
  std::vector<Asked> asked;
  bool is_too_large = false;
  for (int window = 0; window < k_windows && !is_too_large; ++window) {
    std::string bytes;
    for (const Asked& one : asked)
      bytes += finish(one.question);
    asked.clear();
    for (std::uint32_t i = 0; i < k_at_once && !is_too_large; ++i) {
      asked.push_back(valid_call(scene.dice, bounds, question++));
      // Cap'n Proto counts segment headers separately, so the server may accept or refuse a message
      // whose size is near the limit.
      is_too_large = asked.back().frame.size() > bytes_max;
      bytes += asked.back().frame;
    }
    talk->send(bytes);
    scene.tally.attacks += asked.size();
    const auto owes = [&] {
      return std::any_of(asked.begin(), asked.end(), [&](const Asked& one) {
        return !one.may_wait && !talk->listener().has_answered(one.question);
      });
    };
    while (owes() && !talk->has_ended()) {
      if (!talk->hear(k_patience_ms)) {
        if (!is_too_large) scene.trouble_is("a call is not answered");
        return;
      }
    }
    if (talk->has_ended()) {
      if (!is_too_large && scene.door != Door::stranger)
        scene.trouble_is("the server ended a connection whose calls can be read");
      break;
    }
    for (const Asked& one : asked) {
      if (scene.door == Door::stranger && talk->listener().has_results(one.question))
        scene.trouble_is("a stranger's call was let in");
    }
  }
  const bool ended_by_itself = talk->has_ended();
  talk->end();
  scene.tally.reached += talk->reached(ended_by_itself);
}

// Most of these messages end the connection, so each connection sends only a few.
void mutated_messages(const Scene& scene) {
  const Bounds bounds = bounds_of(scene);
  send_messages(scene, 2,
                [&](std::uint32_t question) { return mutated(scene.dice, bounds, question); });
}

void protocol_messages(const Scene& scene) {
  send_messages(scene, 1, [&](std::uint32_t) { return odd_protocol(scene.dice); });
}

void pipelined_calls(const Scene& scene) {
  send_messages(scene, 12,
                [&](std::uint32_t question) { return pipelined_call(scene.dice, question); });
}

void capabilities(const Scene& scene) {
  send_messages(scene, 1, [&](std::uint32_t question) {
    std::string frames;
    for (const std::string& frame : calls_with_capabilities(scene.dice, question))
      frames += frame;
    return frames;
  });
}

void pointers(const Scene& scene) {
  send_messages(scene, 12,
                [&](std::uint32_t question) { return odd_pointers(scene.dice, question); });
}

void broken_frames(const Scene& scene) {
  send_messages(scene, 1, [&](std::uint32_t) { return broken_frame(scene.dice); });
}

// Goal: a peer that disconnects in the middle of a message does the server no harm.
void cut_streams(const Scene& scene) {
  auto talk = begin(scene);
  if (!talk) return;
  std::string bytes = first_words(scene);
  const Bounds bounds = bounds_of(scene);
  for (std::uint32_t i = 0; i < 4; ++i)
    bytes += valid_call(scene.dice, bounds, k_first_question + i).frame;
  bytes.resize(1 + scene.dice.below(bytes.size() - 1));
  talk->send(bytes);
  if (scene.dice.one_in(3)) {
    talk->hear(1);
    talk->judge();
  } else {
    talk->end();
  }
  ++scene.tally.attacks;
  if (talk->listener().messages() > 0) ++scene.tally.reached;
}

// Goal: if a peer reads no answers, they don't accumulate in the server. When the connection ends,
// the server drops its answers.
void unread_answers(const Scene& scene) {
  auto talk = begin_opened(scene);
  if (!talk) return;
  const bool never_reads = scene.dice.one_in(3);
  const Bounds bounds = bounds_of(scene);
  constexpr std::uint32_t k_messages = 200;
  std::uint32_t sent = 0;
  for (bool is_taken = true; is_taken && sent < k_messages; ++sent) {
    const Asked asked = valid_call(scene.dice, bounds, k_first_question + sent);
    is_taken = talk->line().send_unread(asked.frame + finish(asked.question), 20);
  }
  scene.tally.attacks += sent;
  // The tally counts only answers that were read. The first connection always reads answers, to
  // check that the server sends them.
  if (never_reads && scene.tally.reached > 0) return;
  const std::uint64_t before = talk->listener().messages();
  talk->end();
  scene.tally.reached += talk->listener().messages() - before;
}

void noise(const Scene& scene) {
  auto talk = begin(scene);
  if (!talk) return;
  if (scene.dice.one_in(2)) talk->send(first_words(scene));
  talk->send(random_bytes(scene.dice, 1 + scene.dice.below(3000)));
  talk->end();
  ++scene.tally.attacks;
  ++scene.tally.reached;  // the server ended the line, so it read the message
}

// Goal: the server accepts no wrong token. Method: log in with a wrong token, send a call, and
// sometimes log in a second time.
void wrong_logins(const Scene& scene) {
  auto talk = begin(scene);
  if (!talk) return;
  const std::string token = wrong_token(scene.dice, scene.target.token);
  std::string bytes = login(token);
  const Asked asked = valid_call(scene.dice, {.text_bytes_max = 1000}, k_first_question);
  bytes += asked.frame;
  talk->send(bytes);
  // The second login uses a valid token, and must be refused too.
  if (scene.dice.one_in(4)) {
    std::string again = login(scene.target.token);
    talk->send(again);
  }
  talk->end();
  ++scene.tally.attacks;
  if (talk->listener().messages() > 0) ++scene.tally.reached;
  if (talk->listener().has_results(asked.question)) scene.trouble_is("a wrong token was let in");
}

void await_end(const Scene& scene, Line& line) {
  std::string bytes;
  while (true) {
    const Got got = line.receive(bytes, k_patience_ms);
    bytes.clear();
    if (got == Got::ended) break;
    if (got == Got::nothing) {
      scene.trouble_is("the server keeps a connection whose peer has ended it");
      return;
    }
  }
  ++scene.tally.reached;
}

}  // namespace sleight::attack
