// Goal: messages between the daemon and a backend follow docs/BACKENDS.md. If a key is missing, it
// has its default value. Errors name the wrong key.
#include "service/backend/messages.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <map>
#include <string>

#include "common/base/error.h"
#include "common/json/value.h"

namespace sleight::backend::messages_test {

using ::testing::HasSubstr;

const AttemptName k_attempt{.daemon = "abcdefgh", .job = 17, .epoch = 3};

using Json = json::Value;

std::string refusal_of(const std::function<void()>& read) {
  try {
    read();
  } catch (const base::Error& error) {
    return error.what();
  }
  return "taken";
}

TEST(Messages, QuestionsSayWhatTheirVerbNeeds) {
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
  const auto asked = [&](const char* verb) {
    const std::string text = text_of_question(verb, question);
    EXPECT_TRUE(text.ends_with("}\n"));
    return Json::parse(text);
  };
  const Json attempt{{"daemon", "abcdefgh"}, {"job", 17}, {"epoch", 3}};
  EXPECT_EQ(asked("launch"), (Json{{"version", 1},
                                   {"attempt", attempt},
                                   {"folder", question.order.folder},
                                   {"command", question.order.command},
                                   {"label", "sleight-17"},
                                   {"cores", 4},
                                   {"ranks", 8},
                                   {"memory_bytes", 1ULL << 40U},
                                   {"options", question.order.options}}));
  EXPECT_EQ(asked("state"), (Json{{"version", 1}, {"attempt", attempt}}));
  EXPECT_EQ(asked("signal"), (Json{{"version", 1}, {"attempt", attempt}, {"how", "now"}}));
  EXPECT_EQ(asked("list"), (Json{{"version", 1}, {"daemon", "abcdefgh"}}));
  EXPECT_EQ(asked("log"), (Json{{"version", 1},
                                {"attempt", attempt},
                                {"folder", question.order.folder},
                                {"bytes_max", 5}}));
  const Question without_options{.order = {.name = k_attempt, .label = "\xff\xfe"}};
  const std::string text = text_of_question("launch", without_options);
  EXPECT_THAT(text, HasSubstr(R"("options":{})"));
  EXPECT_THAT(text, HasSubstr("\xef\xbf\xbd")) << "bytes that are no UTF-8";
}

TEST(Messages, AnswersAreReadAsTheyAreStated) {
  for (const State state :
       {State::absent, State::waiting, State::running, State::gone, State::unknown}) {
    const Json answer{{"version", 1},
                      {"state", name_of(state)},
                      {"id", "812"},
                      {"words", "wörds"},
                      {"cause", "taken"}};
    EXPECT_EQ(seen_of(answer.dump()),
              (Seen{.state = state, .id = "812", .words = "wörds", .cause = Cause::taken}));
  }
  EXPECT_TRUE(signalled_of(R"({"version":1,"signalled":true})"));
  EXPECT_FALSE(signalled_of(R"({"version":1,"signalled":false})"));
  const std::string all =
      R"({"version":1,"attempts":[{"attempt":{"daemon":"abcdefgh","job":17,"epoch":3},
          "state":"running","id":"1"}]})";
  EXPECT_EQ(list_of("abcdefgh", all),
            (std::map<AttemptName, Seen>{{k_attempt, {.state = State::running, .id = "1"}}}));
  EXPECT_TRUE(list_of("strangers", all).empty());
  EXPECT_EQ(log_of(R"({"version":1,"log":"hello\n"})", 100), "hello\n");
  EXPECT_EQ(log_of(R"({"version":1,"log":"hello\n"})", 3), "lo\n");
}

TEST(Messages, WhatIsMissingOrNewHasItsDefault) {
  const Seen seen = seen_of(R"({"version":1,"new":{"a":[1]},"state":"gone","cause":"of later"})");
  EXPECT_EQ(seen, (Seen{.state = State::gone}));
  EXPECT_EQ(seen.cause, Cause::itself);
  EXPECT_FALSE(signalled_of(R"({"version":1})"));
  EXPECT_EQ(log_of(R"({"version":1})", 9), "");
}

TEST(Messages, WhatIsWrongIsRefused) {
  const auto seen = [](const std::string& text) { return refusal_of([&] { seen_of(text); }); };
  EXPECT_THAT(seen("no JSON"), HasSubstr("not a JSON object"));
  EXPECT_THAT(seen("[]"), HasSubstr("not a JSON object"));
  EXPECT_THAT(seen(R"({"state":"gone"})"), HasSubstr("version"));
  EXPECT_THAT(seen(R"({"version":2,"state":"gone"})"), HasSubstr("version"));
  EXPECT_THAT(seen(R"({"version":1,"state":"lost"})"), HasSubstr("state"));
  EXPECT_THAT(seen(R"({"version":1,"state":7})"), HasSubstr("state"));
  EXPECT_THAT(seen(R"({"version":1,"state":"gone","id":812})"), HasSubstr("id"));
  EXPECT_THAT(refusal_of([] { signalled_of(R"({"version":1,"signalled":1})"); }),
              HasSubstr("signalled"));
  const auto listed = [](const std::string& entry) {
    return refusal_of([&] { list_of("abcdefgh", R"({"version":1,"attempts":[)" + entry + "]}"); });
  };
  EXPECT_THAT(listed("1"), HasSubstr("attempts"));
  EXPECT_THAT(listed(R"({"state":"gone"})"), HasSubstr("attempt"));
  EXPECT_THAT(listed(R"({"attempt":{"daemon":"X","job":1,"epoch":1},"state":"gone"})"),
              HasSubstr("daemon"));
  EXPECT_THAT(listed(R"({"attempt":{"daemon":"abcdefgh","job":-1,"epoch":1},"state":"gone"})"),
              HasSubstr("job"));
  EXPECT_THAT(refusal_of([] { list_of("abcdefgh", R"({"version":1})"); }), HasSubstr("attempts"));
}

}  // namespace sleight::backend::messages_test
