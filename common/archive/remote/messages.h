// The protocol between a reader process and its client.
//
// The reader (archive/reader_program) starts with an answer numbered 0 that describes the archive's
// contents. The reader then answers each question. An answer repeats the question's number:
//
//   question  number u32, dataset u32, first u64, count u64
//   answer    number u32, kind u8, type u8, nothing u16, bytes u64, followed by `bytes` bytes:
//             contents   the groups (encode_contents)
//             values     elements in the type's own size; each text as its length u32 and its bytes
//             refusal    why the reader can't answer, for people, without the archive's name;
//                        its type is 1 if the archive is not at fault, which is possible only
//                        for the first answer
//
// Datasets are numbered from 0 in the order of the contents. Numbers are little-endian. Reader and
// client come from one build, so the protocol has no versions.
//
// A hostile file may have taken over the reader, so every decoding function accepts any bytes.
// Thread safety: values and pure functions.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "common/archive/model.h"
#include "common/base/bytes.h"
#include "common/base/result.h"

namespace sleight::archive::remote {

/// Descriptors that the reader process has from its start.
inline constexpr int k_questions_descriptor = 0;
inline constexpr int k_answers_descriptor = 1;
inline constexpr int k_archive_descriptor = 3;
/// A pipe that the client keeps open without writing. The reader ends when the pipe closes.
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

inline constexpr std::uint8_t k_of_archive = 0;
inline constexpr std::uint8_t k_of_environment = 1;
inline constexpr std::uint8_t k_of_memory = 2;  ///< too little memory

struct AnswerHead {
  std::uint32_t number = 0;
  AnswerKind kind = AnswerKind::refusal;  ///< may be any byte in a received answer
  std::uint8_t type = 0;  ///< for values the ElementType, for a refusal the party at fault
  std::uint16_t nothing = 0;
  std::uint64_t bytes = 0;
  bool operator==(const AnswerHead&) const = default;
};
inline constexpr std::size_t k_head_bytes = 16;
using HeadBytes = std::array<std::byte, k_head_bytes>;
HeadBytes encode(const AnswerHead& head);
AnswerHead decode_head(const HeadBytes& bytes);

/// Maximum size of contents; typical archives have some tens of kilobytes.
inline constexpr std::uint64_t k_contents_bytes_max = 16 * 1024 * 1024;
/// Maximum size of a refusal.
inline constexpr std::uint64_t k_refusal_bytes_max = 64 * 1024;

base::Bytes encode_contents(const std::vector<Group>& groups);
/// Returns the groups, or the reason why the bytes can't be decoded. The caller must check the
/// groups with fault_of_contents (contents_check.h).
base::Result<std::vector<Group>, std::string> decode_contents(base::BytesView bytes);

/// Encode and decode the texts of one answer. There are `count` texts; none is longer than
/// `text_bytes`.
base::Bytes encode_texts(const std::vector<std::string>& texts);
base::Result<std::vector<std::string>, std::string> decode_texts(base::BytesView bytes,
                                                                 std::uint64_t count,
                                                                 std::uint64_t text_bytes);
/// Returns the largest size of `bytes` that decode_texts accepts.
std::uint64_t texts_bytes_max(std::uint64_t count, std::uint64_t text_bytes);

/// Returns the size of a number or flag in an answer. REQUIRES: type is not text.
std::size_t size_of(ElementType type);

}  // namespace sleight::archive::remote
