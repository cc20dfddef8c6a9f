// Acts as a reader process that a hostile file has taken over, for remote_source_test.cpp. The
// process is confined like the real reader. Then the process misbehaves: the first word of its
// "archive" tells how.
#include <fcntl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <csignal>
#include <cstring>
#include <string>
#include <string_view>
#include <vector>

#include "common/archive/format.h"
#include "common/archive/reader_program/answers.h"
#include "common/archive/reader_program/program.h"
#include "common/archive/remote/messages.h"

namespace sleight::archive::reader_program {
namespace {

using remote::AnswerHead;
using remote::AnswerKind;

constexpr std::uint64_t k_elements = 4;

std::string told() {
  std::array<char, 64> bytes{};
  const ssize_t got = ::pread(remote::k_archive_descriptor, bytes.data(), bytes.size(), 0);
  return {bytes.data(), static_cast<std::size_t>(got > 0 ? got : 0)};
}

/// Returns the contents that an honest reader sends. /posterior has a coordinate (dataset 0) and
/// words (dataset 1).
std::vector<Group> groups() {
  const Dimension draw{"draw", k_elements};
  return {{.name = std::string(k_root),
           .attributes = {{"format", std::string(k_format_name)},
                          {"format_version", k_format_version}}},
          {.name = std::string(k_posterior),
           .datasets = {
               {.name = "draw", .type = ElementType::i64, .dims = {draw}},
               {.name = "words", .type = ElementType::text, .dims = {draw}, .text_bytes = 8}}}};
}

bool say_contents(const std::vector<Group>& said) {
  const base::Bytes bytes = remote::encode_contents(said);
  return say({.kind = AnswerKind::contents, .bytes = bytes.size()}, bytes);
}

/// Sends the head and then `bytes` zeros, even if the head states another size.
void say_zeros(const AnswerHead& head, std::size_t bytes) {
  say(head, base::Bytes(bytes));
}

[[noreturn]] void fall_silent() {
  remote::Question question;
  while (hear(question)) {
  }
  ::_exit(0);
}

void spin() {
  std::atomic<std::uint64_t> turns{0};
  while (true)
    ++turns;
}

/// Tries an action that confine.h forbids. If the action succeeds, the process continues as an
/// honest reader.
void attempt(std::string_view what) {
  if (what == "socket") ::socket(AF_INET, SOCK_STREAM, 0);
  if (what == "write") ::open("/tmp/sleight-lying-reader", O_WRONLY | O_CREAT, 0600);
  if (what == "fork") ::fork();
  if (what == "kill") ::kill(::getppid(), 0);
  if (what == "exec") {
    char* const none[] = {nullptr};
    ::execve("/bin/true", none, none);
  }
}

void answer_falsely(std::string_view lie, const remote::Question& question) {
  AnswerHead head{.number = question.number,
                  .kind = AnswerKind::values,
                  .type = static_cast<std::uint8_t>(ElementType::i64),
                  .bytes = question.count * 8};
  const std::size_t bytes = head.bytes;
  if (lie == "fewer")
    return say_zeros({.number = head.number, .kind = head.kind, .type = head.type, .bytes = 8}, 8);
  if (lie == "huge") {
    head.bytes = ~std::uint64_t{0};
    return say_zeros(head, bytes);
  }
  if (lie == "type") head.type = static_cast<std::uint8_t>(ElementType::f64);
  if (lie == "kind") head.kind = AnswerKind{77};
  if (lie == "number") ++head.number;
  if (lie == "padding") head.nothing = 1;
  if (lie == "blame") {
    head.kind = AnswerKind::refusal;
    head.type = remote::k_of_environment;
  }
  if (lie == "more") return say_zeros(head, bytes + 1);
  if (lie == "half") {
    say_zeros(head, bytes / 2);
    ::_exit(0);
  }
  if (lie == "escape") {
    const base::Bytes texts = remote::encode_texts({"a", "\033[2J", "c", "d"});
    say({.number = head.number,
         .kind = AnswerKind::values,
         .type = static_cast<std::uint8_t>(ElementType::text),
         .bytes = texts.size()},
        texts);
    return;
  }
  if (lie == "long_text") {
    const base::Bytes texts = remote::encode_texts({"a", "b", "c", "123456789"});
    say({.number = head.number,
         .kind = AnswerKind::values,
         .type = static_cast<std::uint8_t>(ElementType::text),
         .bytes = texts.size()},
        texts);
    return;
  }
  if (lie == "refusal") {
    const std::string reason = "a chunk is damaged \033[2J";
    say({.number = head.number, .kind = AnswerKind::refusal, .bytes = reason.size()},
        std::as_bytes(std::span<const char>(reason)));
    return;
  }
  if (lie == "late") fall_silent();
  if (lie == "crash_later") __builtin_trap();
  say_zeros(head, bytes);
}

int lie(const Given& given) {
  const std::string word = told();
  if (word == "crash") __builtin_trap();
  if (word == "exit") return 3;
  if (word == "silent") fall_silent();
  if (word == "spin") spin();
  if (word == "bomb") {
    return answer(
        [&given]() -> std::unique_ptr<Source> {
          std::vector<char> bomb(2 * given.memory_bytes, 'x');
          ::_exit(bomb[bomb.size() / 2]);
        },
        given.memory_bytes);
  }
  if (word == "huge_contents") {
    say_zeros({.kind = AnswerKind::contents, .bytes = std::uint64_t{1} << 60}, 8);
    fall_silent();
  }
  if (word == "broken_contents") {
    say_zeros({.kind = AnswerKind::contents, .bytes = 7}, 7);
    fall_silent();
  }
  std::vector<Group> said = groups();
  if (word == "escaping_name") said[1].datasets[1].name = "../../etc/passwd";
  attempt(word);
  if (!say_contents(said)) return 0;
  if (word == "unasked") say_zeros({.number = 1, .kind = AnswerKind::values, .bytes = 8}, 8);
  remote::Question question;
  while (hear(question))
    answer_falsely(word, question);
  return 0;
}

}  // namespace
}  // namespace sleight::archive::reader_program

int main(int argc, char** argv) {
  return sleight::archive::reader_program::run_confined(argc, argv,
                                                        &sleight::archive::reader_program::lie);
}
