#include "tests/attacks/tls_acts.h"

#include <algorithm>
#include <string>
#include <utility>

#include "tests/attacks/messages.h"

namespace sleight::attack {
namespace {

enum ContentType : std::uint8_t { change_cipher = 20, alert = 21, handshake = 22, data = 23 };

/// Returns a record whose header states `size`, even if its content has another size.
std::string record(std::uint8_t type, std::size_t size, std::string_view content) {
  std::string bytes = {static_cast<char>(type), 3, 3, static_cast<char>(size >> 8U),
                       static_cast<char>(size)};
  bytes += content;
  return bytes;
}

std::string record(std::uint8_t type, std::string_view content) {
  return record(type, content.size(), content);
}

std::string hello_of(const Scene& scene) {
  Tls tls(scene.dice.one_in(3) ? scene.target.old_tls : scene.target.tls);
  tls.shake();
  return tls.take();
}

void garble(Dice& dice, std::string& bytes) {
  for (std::uint64_t i = 0, changes = 1 + dice.below(8); i < changes; ++i) {
    char& c = bytes[dice.below(bytes.size())];
    c = dice.one_in(2) ? static_cast<char>(c ^ (1 << dice.below(8)))
                       : static_cast<char>(dice.bits());
  }
}

std::unique_ptr<Line> reach(const Scene& scene) {
  auto line = line_to_port(scene.target.address, scene.episode);
  if (!line) ++scene.tally.turned_away;
  return line;
}

void send_and_end(const Scene& scene, Line& line, std::string_view bytes) {
  line.send(bytes);
  line.end_sending();
  ++scene.tally.attacks;
  await_end(scene, line);
}

}  // namespace

void tls_noise(const Scene& scene) {
  const auto line = reach(scene);
  if (!line) return;
  std::string bytes = random_bytes(scene.dice, 1 + scene.dice.below(1500));
  if (scene.dice.one_in(2)) bytes = record(handshake, bytes);
  send_and_end(scene, *line, bytes);
}

void tls_hellos(const Scene& scene) {
  const auto line = reach(scene);
  if (!line) return;
  std::string bytes = hello_of(scene);
  garble(scene.dice, bytes);
  send_and_end(scene, *line, bytes);
}

// Goal: the server accepts or refuses TLS records of any size, order and number, and never hangs.
void tls_records(const Scene& scene) {
  const auto line = reach(scene);
  if (!line) return;
  Dice& dice = scene.dice;
  const std::string hello = hello_of(scene);
  const std::string content = hello.substr(5);
  std::string bytes;
  switch (dice.below(8)) {
    case 0:  // records of one byte each
      for (const char c : content)
        bytes += record(handshake, std::string(1, c));
      break;
    case 1:  // a hello cut at any place
      bytes = hello.substr(0, 1 + dice.below(hello.size() - 1));
      break;
    case 2:  // larger than the maximum record
      bytes = record(handshake, 0xFFFF, random_bytes(dice, 2000) + std::string(60'000, 'x'));
      break;
    case 3:  // empty records, of the handshake and of data
      for (std::uint64_t i = 0; i < 200; ++i)
        bytes += record(dice.one_in(2) ? handshake : data, "");
      break;
    case 4:  // alerts at the level of warnings
      for (std::uint64_t i = 0; i < 50; ++i)
        bytes += record(alert, std::string{1, static_cast<char>(dice.bits())});
      bytes += hello;
      break;
    case 5:
      for (std::uint64_t i = 0; i < 100; ++i)
        bytes += record(change_cipher, std::string(1, 1));
      bytes += hello;
      break;
    case 6:  // data before there is a key
      bytes = hello + record(data, random_bytes(dice, 1 + dice.below(16'000)));
      break;
    default:  // the hello several times
      for (int i = 0; i < 5; ++i)
        bytes += hello;
      break;
  }
  send_and_end(scene, *line, bytes);
}

// Goal: an incomplete or damaged TLS handshake does the server no harm. Method: send a hello. Then
// disconnect, or send a changed or truncated reply to the server's answer.
void tls_half_handshakes(const Scene& scene) {
  auto line = reach(scene);
  if (!line) return;
  Dice& dice = scene.dice;
  Tls tls(dice.one_in(2) ? scene.target.old_tls : scene.target.tls);
  tls.shake();
  ++scene.tally.attacks;
  if (!line->send(tls.take())) return;
  std::string answer;
  if (line->receive(answer, k_patience_ms) != Got::bytes) return;
  ++scene.tally.reached;
  if (dice.one_in(3)) return;  // leaves without an answer
  tls.give(answer);
  tls.shake();
  std::string bytes = tls.take();
  if (!bytes.empty()) {
    if (dice.one_in(2)) {
      garble(dice, bytes);
    } else {
      bytes.resize(dice.below(bytes.size()));
    }
    line->send(bytes);
  }
  line->end_sending();
  await_end(scene, *line);
}

// Goal: after a TLS handshake, key updates, new handshakes, alerts and bad records do the server no
// harm.
void tls_after_handshakes(const Scene& scene) {
  auto line = reach(scene);
  if (!line) return;
  Dice& dice = scene.dice;
  const bool is_old = dice.one_in(2);
  Tls tls(is_old ? scene.target.old_tls : scene.target.tls);
  if (!shake_hands(*line, tls)) {
    ++scene.tally.turned_away;
    return;
  }
  std::string bytes;
  switch (dice.below(6)) {
    case 0:
      for (int i = 0; i < 300; ++i) {
        if (is_old) {
          SSL_renegotiate(tls.ssl());
        } else {
          SSL_key_update(tls.ssl(), SSL_KEY_UPDATE_REQUESTED);
        }
        tls.shake();
      }
      bytes = tls.take();
      break;
    case 1:
      bytes = tls.encrypt(opening());
      garble(dice, bytes);
      break;
    case 2:
      for (int i = 0; i < 20; ++i)
        bytes += record(alert, std::string{static_cast<char>(1 + dice.below(2)),
                                           static_cast<char>(dice.bits())});
      break;
    case 3:
      SSL_shutdown(tls.ssl());
      bytes = tls.take() + tls.encrypt(opening());
      break;
    case 4:
      bytes = record(data, random_bytes(dice, 1 + dice.below(16'384)));
      break;
    default:  // not encrypted
      bytes = opening();
      break;
  }
  send_and_end(scene, *line, bytes);
}

}  // namespace sleight::attack
