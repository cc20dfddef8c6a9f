// Goal: questions and answers are read as they are written; what is missing or new has its default,
// and what is wrong is refused by name.
#include "service/backend/messages.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

namespace sleight::backend::messages_test {

using ::testing::HasSubstr;

const AttemptName k_attempt{.daemon = "abcdefgh", .job = 17, .epoch = 3};

std::string refusal_of(std::string_view verb, const std::string& text) {
  try {
    question_of(verb, text);
  } catch (const base::Error& error) {
    return error.what();
  }
  return "taken";
}

TEST(Messages, QuestionsAreReadAsTheyAreWritten) {
  const Question question{.order = {.name = k_attempt,
                                    .folder = "/jobs/\"17\"",
                                    .command = {"/bin/keeper", "a b", "\n"},
                                    .label = "sleight-17",
                                    .cores = 4,
                                    .ranks = 8,
                                    .memory_bytes = 1ULL << 40U,
                                    .options = {{"account", "x"}, {"more", "--a=b --c"}}},
                          .how = keeper::Stop::now,
                          .bytes_max = 5};
  EXPECT_EQ(question_of("launch", text_of_question("launch", question)).order, question.order);
  EXPECT_EQ(question_of("state", text_of_question("state", question)).order.name, k_attempt);
  EXPECT_EQ(question_of("signal", text_of_question("signal", question)).how, keeper::Stop::now);
  EXPECT_EQ(question_of("list", text_of_question("list", question)).order.name.daemon, "abcdefgh");
  const Question log = question_of("log", text_of_question("log", question));
  EXPECT_EQ(log.order.folder, question.order.folder);
  EXPECT_EQ(log.bytes_max, 5U);
}

TEST(Messages, AnswersAreReadAsTheyAreWritten) {
  for (const State state :
       {State::absent, State::waiting, State::running, State::gone, State::unknown}) {
    const Seen seen{.state = state, .id = "812", .words = "wörds", .cause = Cause::taken};
    EXPECT_EQ(seen_of(text_of_seen(seen)), seen);
  }
  EXPECT_TRUE(signalled_of(text_of_signalled(true)));
  EXPECT_FALSE(signalled_of(text_of_signalled(false)));
  const std::map<AttemptName, Seen> all{{k_attempt, {.state = State::running, .id = "1"}}};
  EXPECT_EQ(list_of("abcdefgh", text_of_list(all)), all);
  EXPECT_TRUE(list_of("strangers", text_of_list(all)).empty());
  EXPECT_EQ(log_of(text_of_log("hello\n"), 100), "hello\n");
  EXPECT_EQ(log_of(text_of_log("hello\n"), 3), "lo\n");
  EXPECT_THAT(text_of_log("\xff\xfe"), HasSubstr("\xef\xbf\xbd")) << "bytes that are no UTF-8";
}

TEST(Messages, WhatIsMissingHasItsDefault) {
  const Question question = question_of(
      "launch",
      R"({"version":1,"new":{"a":[1]},"attempt":{"daemon":"abcdefgh","job":1,"epoch":1,"b":2},
          "folder":"/f","command":["/bin/true"]})");
  EXPECT_EQ(question.order.cores, 1U);
  EXPECT_EQ(question.order.ranks, 0U);
  EXPECT_TRUE(question.order.options.empty());
  EXPECT_EQ(seen_of(R"({"version":1,"state":"gone","cause":"of a later version"})").cause,
            Cause::itself);
}

TEST(Messages, WhatIsWrongIsRefused) {
  const std::string attempt = R"("attempt":{"daemon":"abcdefgh","job":1,"epoch":1})";
  EXPECT_THAT(refusal_of("state", "no JSON"), HasSubstr("no JSON object"));
  EXPECT_THAT(refusal_of("state", "[]"), HasSubstr("no JSON object"));
  EXPECT_THAT(refusal_of("state", "{" + attempt + "}"), HasSubstr("version"));
  EXPECT_THAT(refusal_of("state", R"({"version":2})"), HasSubstr("version"));
  EXPECT_THAT(refusal_of("state", R"({"version":1})"), HasSubstr("attempt"));
  EXPECT_THAT(refusal_of("dance", R"({"version":1})"), HasSubstr("no verb"));
  EXPECT_THAT(refusal_of("list", R"({"version":1,"daemon":"X"})"), HasSubstr("daemon"));
  EXPECT_THAT(refusal_of("signal", R"({"version":1,"how":"gently",)" + attempt + "}"),
              HasSubstr("how"));
  const auto launch = [&](const std::string& more) {
    return refusal_of("launch", R"({"version":1,)" + attempt + "," + more + "}");
  };
  EXPECT_THAT(launch(R"("folder":"/f","command":"/bin/true")"), HasSubstr("command"));
  EXPECT_THAT(launch(R"("folder":"/f","command":[1])"), HasSubstr("command"));
  EXPECT_THAT(launch(R"("folder":7,"command":["/bin/true"])"), HasSubstr("folder"));
  EXPECT_THAT(launch(R"("folder":"f","command":["/bin/true"])"), HasSubstr("absolute"));
  EXPECT_THAT(launch(R"("folder":"/f","command":["/bin/true"],"cores":-1)"), HasSubstr("cores"));
  EXPECT_THAT(launch(R"("folder":"/f","command":["/bin/true"],"options":{"a":1})"),
              HasSubstr("option"));
  EXPECT_THROW(seen_of(R"({"version":1,"state":"lost"})"), base::Error);
  EXPECT_THROW(list_of("abcdefgh", R"({"version":1,"attempts":[1]})"), base::Error);
}

}  // namespace sleight::backend::messages_test
