#include "services/drivers/isel/isel_text.h"

#include <gtest/gtest.h>

#include <string_view>

namespace intaglio::drivers {
namespace {

std::vector<IselAnswer> Fed(IselAnswerReader& reader, std::string_view text) {
  std::vector<IselAnswer> answers;
  reader.Feed(std::as_bytes(std::span(text)), answers);
  return answers;
}

TEST(IselText, ReadsAPlaceInTwosComplementByteByByte) {
  IselAnswerReader reader;
  reader.Expect(IselExpected::kPlace);
  std::vector<IselAnswer> all;
  for (const char byte : std::string("0000100FFFFFF80000A")) {
    for (const IselAnswer& answer : Fed(reader, std::string_view(&byte, 1)))
      all.push_back(answer);
  }
  ASSERT_EQ(all.size(), 1u);
  EXPECT_EQ(all[0].place, (IselSteps{256, -1, -8388598}));
  EXPECT_FALSE(reader.is_expecting());
}

TEST(IselText, AnswersComeInTheOrderInWhichTheyAreExpected) {
  IselAnswerReader reader;
  for (const IselExpected what : {IselExpected::kCode, IselExpected::kPlace,
                                  IselExpected::kPlace, IselExpected::kCode}) {
    reader.Expect(what);
  }
  const auto answers = Fed(reader, "090000001000002000003H0");
  ASSERT_EQ(answers.size(), 4u);
  EXPECT_EQ(answers[0].code, '0');
  EXPECT_EQ(answers[1].code, '9');
  EXPECT_FALSE(answers[1].place);
  EXPECT_EQ(answers[2].place, (IselSteps{1, 2, 3}));
  EXPECT_EQ(answers[3].code, 'H') << "and what nothing expects is dropped";
}

TEST(IselText, ADamagedPlaceIsNone) {
  IselAnswerReader reader;
  reader.Expect(IselExpected::kPlace);
  const auto answers = Fed(reader, "00000x");
  ASSERT_EQ(answers.size(), 1u);
  EXPECT_EQ(answers[0].code, '0');
  EXPECT_FALSE(answers[0].place);
}

TEST(IselText, AMoveHasEightNumbers) {
  EXPECT_EQ(IselMove({100, -200, 3}, {1000, 2000, 100}),
            "@0M100,1000,-200,2000,3,100,0,100\r");
}

TEST(IselText, EachErrorHasItsSentence) {
  for (const char code : std::string("2579DFHR")) {
    EXPECT_EQ(TextOfIselError(code).find("answered '"), std::string::npos) << code;
  }
  EXPECT_NE(TextOfIselError('x').find("'x'"), std::string::npos);
  EXPECT_NE(TextOfIselError('\x01').find("byte 1"), std::string::npos);
}

}  // namespace
}  // namespace intaglio::drivers
