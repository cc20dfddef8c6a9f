// What a reader process and the program that asks it say to one another.
//
// The reader (archive/reader_program) begins: an answer with the number 0 says what is in the
// archive. Then each question is followed by one answer with the question's number:
//
//   question  number u32, dataset u32, first u64, count u64
//   answer    number u32, kind u8, type u8, nothing u16, bytes u64, and then so many bytes:
//             contents   the groups (encode_contents)
//             values     elements in the type's own size; each text as its length u32 and its bytes
//             refusal    why the reader can't give it, for people, without the archive's name;
//                        its type is 1 where that isn't the archive's fault, which can be at the
//                        beginning alone
//
// Datasets are numbered from 0 in the order in which the contents have them. Numbers are
// little-endian. Both ends are of one build, so there are no versions.
//
// The reader may have been taken over by a hostile file: everything here that takes an answer apart
// expects any bytes. Thread safety: values and pure functions.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "common/archive/model.h"
#include "common/base/bytes.h"
#include "common/base/result.h"

namespace sleight::archive::remote {

/// Where the reader process has its ends, from its first instruction on.
inline constexpr int k_questions_descriptor = 0;
inline constexpr int k_answers_descriptor = 1;
inline constexpr int k_archive_descriptor = 3;
/// A pipe of which the program that asks holds the other end, and says nothing: it ends with it.
inline constexpr int k_lifeline_descriptor = 4;

struct Question {
  std::uint32_t number = 0;
  std::uint32_t dataset = 0;
  std::uint64_t first = 0;
  std::uint64_t count = 0;
  bool operator==(const Question&) const = default;
};
inline constexpr std::size_t k_question_bytes = 24;
using QuestionBytes = std::array<std::byte, k_question_bytes>;
QuestionBytes encode(const Question& question);
Question decode_question(const QuestionBytes& bytes);

enum class AnswerKind : std::uint8_t { contents = 1, values = 2, refusal = 3 };

/// The type of a refusal.
inline constexpr std::uint8_t k_of_archive = 0;
inline constexpr std::uint8_t k_of_environment = 1;
inline constexpr std::uint8_t k_of_memory = 2;  ///< there is too little for it

/// What every answer begins with.
struct AnswerHead {
  std::uint32_t number = 0;
  AnswerKind kind = AnswerKind::refusal;  ///< any byte, in what a stranger says
  std::uint8_t type = 0;                  ///< of values their ElementType, of a refusal whose fault
  std::uint16_t nothing = 0;
  std::uint64_t bytes = 0;  ///< that follow
  bool operator==(const AnswerHead&) const = default;
};
inline constexpr std::size_t k_head_bytes = 16;
using HeadBytes = std::array<std::byte, k_head_bytes>;
HeadBytes encode(const AnswerHead& head);
AnswerHead decode_head(const HeadBytes& bytes);

/// The longest contents: an archive's are some tens of kilobytes.
inline constexpr std::uint64_t k_contents_bytes_max = 16 * 1024 * 1024;
/// The longest refusal.
inline constexpr std::uint64_t k_refusal_bytes_max = 64 * 1024;

base::Bytes encode_contents(const std::vector<Group>& groups);
/// The groups, of which fault_of_contents (contents_check.h) then judges what is in them; or why
/// the bytes are none.
base::Result<std::vector<Group>, std::string> decode_contents(base::BytesView bytes);

/// Texts as one answer has them, and back: `count` of them, each of at most `text_bytes`.
base::Bytes encode_texts(const std::vector<std::string>& texts);
base::Result<std::vector<std::string>, std::string> decode_texts(base::BytesView bytes,
                                                                 std::uint64_t count,
                                                                 std::uint64_t text_bytes);
/// The most bytes that decode_texts may be given.
std::uint64_t texts_bytes_max(std::uint64_t count, std::uint64_t text_bytes);

/// Of a number or a flag in an answer. REQUIRES: type is not text.
std::size_t size_of(ElementType type);

}  // namespace sleight::archive::remote
