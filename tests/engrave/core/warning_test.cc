#include "engrave/core/warning.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>
#include <string>

namespace intaglio {
namespace {

using ::testing::ElementsAre;
using ::testing::Field;

constexpr auto kLast = WarningCode::kTwoFoci;

TEST(Warning, EveryCodeAndWeightHasAnOwnNameThatIsReadBack) {
  std::set<std::string> names;
  for (int i = 0; i <= static_cast<int>(kLast); ++i) {
    const auto code = static_cast<WarningCode>(i);
    EXPECT_TRUE(names.insert(WarningCodeName(code)).second) << WarningCodeName(code);
    EXPECT_EQ(WarningCodeOf(WarningCodeName(code)), code);
  }
  for (const WarningWeight weight :
       {WarningWeight::kNote, WarningWeight::kWarning, WarningWeight::kConsent}) {
    EXPECT_EQ(WarningWeightOf(WarningWeightName(weight)), weight);
  }
  EXPECT_EQ(WarningCodeOf("of a newer program"), WarningCode::kOther);
  EXPECT_EQ(WarningWeightOf("unheard-of"), WarningWeight::kNote);
}

TEST(Warning, OnlyTheLossOfTheBlockNeedsAConsent) {
  for (int i = 0; i <= static_cast<int>(kLast); ++i) {
    const auto code = static_cast<WarningCode>(i);
    EXPECT_EQ(MakeWarning(code, "").weight == WarningWeight::kConsent,
              code == WarningCode::kBreakage)
        << WarningCodeName(code);
  }
}

TEST(Warning, TheHeaviestComesFirst) {
  const Warnings warnings = {
      MakeWarning(WarningCode::kChosen, "a"), MakeWarning(WarningCode::kOddRays, "b"),
      MakeWarning(WarningCode::kBreakage, "c"), MakeWarning(WarningCode::kHole, "d")};
  EXPECT_THAT(AtLeast(WarningWeight::kWarning, warnings),
              ElementsAre(Field(&Warning::text, "c"), Field(&Warning::text, "b"),
                          Field(&Warning::text, "d")));
  EXPECT_EQ(GreatestWeight(warnings), WarningWeight::kConsent);
  EXPECT_EQ(GreatestWeight({}), WarningWeight::kNote);
  ASSERT_NE(FindConsent(warnings), nullptr);
  EXPECT_EQ(FindConsent(warnings)->text, "c");
  EXPECT_EQ(FindConsent({warnings[0], warnings[1]}), nullptr);
}

}  // namespace
}  // namespace intaglio
