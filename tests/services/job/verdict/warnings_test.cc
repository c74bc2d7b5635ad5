#include "services/job/verdict/warnings.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <iterator>

namespace intaglio {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;

const Warnings kSome = {MakeWarning(WarningCode::kOddRays, "3 of 9 rays"),
                        {WarningCode::kOther, WarningWeight::kConsent, "µ"}};

TEST(WarningMessages, AreReadBackFromEveryForm) {
  EXPECT_EQ(WarningsOf(RecordsOf(kSome)), kSome);
  EXPECT_EQ(WarningsOfBytes(BytesOf(kSome)), kSome);
  Warnings read;
  for (const intaglio_JobWarning& sample : SamplesOf(kSome)) {
    read.push_back(WarningOf(sample));
  }
  EXPECT_EQ(read, kSome);
}

TEST(WarningMessages, ProgramsReadNames) {
  const WarningRecord record = RecordOf(kSome[0]);
  EXPECT_EQ(record.code(), "odd_rays");
  EXPECT_EQ(record.weight(), "warning");
}

TEST(WarningMessages, OfDamagedBytesThereAreNone) {
  EXPECT_THAT(WarningsOfBytes(""), IsEmpty());
  EXPECT_THAT(WarningsOfBytes("\xff\xff"), IsEmpty());
  EXPECT_EQ(WarningOf(intaglio_JobWarning{}).text, "") << "a sample without texts";
}

TEST(WarningMessages, TheOptionThatAcceptsOneNamesItsCode) {
  EXPECT_EQ(AcceptOption(MakeWarning(WarningCode::kBreakage, "")), "--accept breakage");
}

// A row each: | `code` | weight |
TEST(WarningMessages, DocsListEveryCode) {
  std::ifstream file(INTAGLIO_SOURCE_DIR "/docs/jobs.md");
  const std::string docs((std::istreambuf_iterator<char>(file)), {});
  for (int i = 0; i <= static_cast<int>(WarningCode::kTwoFoci); ++i) {
    const Warning warning = MakeWarning(static_cast<WarningCode>(i), "");
    EXPECT_THAT(docs, HasSubstr(std::string("| `") + WarningCodeName(warning.code) +
                                "` | " + WarningWeightName(warning.weight) + " |"));
  }
}

}  // namespace
}  // namespace intaglio
