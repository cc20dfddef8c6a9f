#include "clients/cli/given_request.h"

#include <fmt/format.h>

#include <filesystem>

#include "clients/terminal/output.h"
#include "common/base/file_system.h"
#include "common/request/document.h"
#include "common/request/text.h"

namespace sleight::cli {
namespace {

/// Maximum characters of a word in a request's name.
constexpr std::size_t k_shown_word_characters_max = 40;
constexpr const char* k_standard_input = "-";

std::string request_of_word(const std::string& word, const std::optional<request::Asked>& asked) {
  std::string text =
      fmt::format("[world]\nname = \"spelling\"\nword = {}\n", request::toml_string(word));
  if (!asked) return text;
  const request::Answer answer = asked->answer.value_or(request::Answer::takes);
  return text + fmt::format("\n[stop]\n{} = {}\n",
                            answer == request::Answer::takes   ? "takes"
                            : answer == request::Answer::found ? "found"
                                                               : "independent_solutions",
                            asked->number);
}

}  // namespace

GivenRequest given_request(const std::string& path, const std::string& word,
                           const std::optional<request::Asked>& asked) {
  if (path.empty() && word.empty())
    terminal::refuse_usage("REQUEST.toml or --word WORD is required");
  if (!request::is_utf8(word)) terminal::refuse_usage("--word: expected UTF-8 text");
  if (path.empty()) {
    return {.name = "--word " + request::printable(word, k_shown_word_characters_max),
            .text = request_of_word(word, asked)};
  }
  if (path == k_standard_input)
    return {.name = "standard input",
            .text = base::read_standard_input(request::k_request_bytes_max)};
  return {.name = path, .text = base::read_text_file(path, request::k_request_bytes_max)};
}

std::optional<request::Diagnostic> given_twice(std::span<const request::KeySet> sets,
                                               const OptionsGiven& options) {
  struct Given {
    bool is_given;
    const char* section;
    const char* key;
    std::string option;
  };
  for (const Given& one : {Given{options.seed, "sampler", "seed", "--seed"},
                           Given{options.word, "world", "word", "--word"},
                           Given{!options.answer.empty(), "stop", "", options.answer}}) {
    const request::KeySet* set =
        one.is_given ? request::find_set(sets, one.section, one.key) : nullptr;
    if (set == nullptr) continue;
    return request::Diagnostic{"--set " + set->text, request::k_no_place,
                               fmt::format("conflicts with {}; remove one of them", one.option)};
  }
  return std::nullopt;
}

std::string short_name_of(const std::string& path, const std::string& word) {
  if (path.empty()) return word;
  return path == k_standard_input ? "request" : std::filesystem::path(path).stem().string();
}

}  // namespace sleight::cli
