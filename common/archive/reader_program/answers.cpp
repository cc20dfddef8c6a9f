#include "common/archive/reader_program/answers.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <new>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "common/archive/format.h"
#include "common/base/error.h"

namespace sleight::archive::reader_program {
namespace {

using remote::AnswerHead;
using remote::AnswerKind;
using remote::Question;

struct Numbered {
  const Group* group = nullptr;
  const DatasetSpec* spec = nullptr;
};

std::vector<Numbered> numbered(const Source& source) {
  std::vector<Numbered> all;
  for (const Group& group : source.groups()) {
    for (const DatasetSpec& spec : group.datasets)
      all.push_back({&group, &spec});
  }
  return all;
}

bool say_all(std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const ssize_t said = ::write(remote::k_answers_descriptor, bytes.data(), bytes.size());
    if (said < 0 && errno == EINTR) continue;
    if (said <= 0) return false;
    bytes = bytes.subspan(static_cast<std::size_t>(said));
  }
  return true;
}

bool refuse(std::uint32_t number, std::string_view reason,
            std::uint8_t type = remote::k_of_archive) {
  reason = reason.substr(0, remote::k_refusal_bytes_max);
  return say({.number = number, .kind = AnswerKind::refusal, .type = type, .bytes = reason.size()},
             std::as_bytes(std::span<const char>(reason)));
}

/// Calls `work`. If `work` throws, sends the reason as a refusal.
template <class Work>
bool or_refuse(std::uint32_t number, std::uint64_t memory_bytes, const Work& work) {
  try {
    return work();
  } catch (const base::Error& error) {
    std::string_view reason = error.what();
    const std::string name = std::string(k_nameless) + ": ";
    if (reason.starts_with(name)) reason.remove_prefix(name.size());
    return refuse(number, reason);
  } catch (const std::bad_alloc&) {
    return refuse(
        number, fmt::format("reading the archive takes more than {} bytes of memory", memory_bytes),
        remote::k_of_memory);
  }
}

bool say_values(std::uint32_t number, const Values& values) {
  AnswerHead head{.number = number,
                  .kind = AnswerKind::values,
                  .type = static_cast<std::uint8_t>(type_of(view_of(values)))};
  if (const auto* texts = std::get_if<std::vector<std::string>>(&values)) {
    const base::Bytes bytes = remote::encode_texts(*texts);
    head.bytes = bytes.size();
    return say(head, bytes);
  }
  return std::visit(
      [&head](const auto& numbers) {
        using Number = typename std::decay_t<decltype(numbers)>::value_type;
        if constexpr (std::is_arithmetic_v<Number>) {
          const std::span<const std::byte> bytes = std::as_bytes(std::span<const Number>(numbers));
          head.bytes = bytes.size();
          return say(head, bytes);
        } else {
          return false;  // texts were handled above
        }
      },
      values);
}

/// Answers questions. While the client processes an answer, reads the dataset's next part in
/// advance, because many clients read a dataset in order.
class ForwardReader {
 public:
  explicit ForwardReader(const Source& source) : source_(source), datasets_(numbered(source)) {}

  bool answer(const Question& question) {
    if (question.dataset >= datasets_.size())
      return refuse(question.number, "there is no such dataset");
    const std::uint64_t total = element_count(*datasets_[question.dataset].spec);
    if (question.first > total || question.count > total - question.first)
      return refuse(question.number, "there are no such elements");
    const bool is_next = question.dataset == next_.dataset && question.first == next_.first;
    const std::uint64_t end = question.first + question.count;
    const bool is_known = is_next && question.count == next_.count && knows_next_;
    knows_next_ = false;
    const Values values = is_known ? std::move(ahead_) : read(question);
    if (!say_values(question.number, values)) return false;
    next_ = {
        .dataset = question.dataset, .first = end, .count = std::min(question.count, total - end)};
    if (next_.count > 0 && next_.count <= k_ahead_elements_max && (is_next || question.first == 0))
      read_ahead();
    return true;
  }

 private:
  /// Maximum number of elements that are read ahead: a few batches.
  static constexpr std::uint64_t k_ahead_elements_max = 8 * k_batch_elements;

  Values read(const Question& question) const {
    const auto& [group, spec] = datasets_[question.dataset];
    return source_.read(group->name, spec->name, question.first, question.count);
  }

  /// Ignore errors here, because they are reported when the data are requested.
  void read_ahead() {
    try {
      ahead_ = read(next_);
      knows_next_ = true;
    } catch (const base::Error&) {
    } catch (const std::bad_alloc&) {
    }
  }

  const Source& source_;
  std::vector<Numbered> datasets_;
  Question next_{.first = ~std::uint64_t{0}};
  Values ahead_;  ///< answer to next_, if already read
  bool knows_next_ = false;
};

}  // namespace

bool say(const AnswerHead& head, std::span<const std::byte> bytes) {
  return say_all(remote::encode(head)) && say_all(bytes);
}

bool hear(Question& question) {
  remote::QuestionBytes bytes{};
  std::span<std::byte> rest(bytes);
  while (!rest.empty()) {
    const ssize_t heard = ::read(remote::k_questions_descriptor, rest.data(), rest.size());
    if (heard < 0 && errno == EINTR) continue;
    if (heard <= 0) return false;
    rest = rest.subspan(static_cast<std::size_t>(heard));
  }
  question = remote::decode_question(bytes);
  return true;
}

int answer(const std::function<std::unique_ptr<Source>()>& open, std::uint64_t memory_bytes) {
  std::unique_ptr<Source> source;
  const bool is_listened_to = or_refuse(0, memory_bytes, [&] {
    source = open();
    const base::Bytes contents = remote::encode_contents(source->groups());
    if (contents.size() > remote::k_contents_bytes_max) {
      source.reset();
      return refuse(0, "the archive's names and attributes are too long");
    }
    return say({.kind = AnswerKind::contents, .bytes = contents.size()}, contents);
  });
  if (!is_listened_to || !source) return 0;
  ForwardReader reader(*source);
  Question question;
  while (hear(question)) {
    const bool goes_on =
        or_refuse(question.number, memory_bytes, [&] { return reader.answer(question); });
    if (!goes_on) break;
  }
  return 0;
}

}  // namespace sleight::archive::reader_program
