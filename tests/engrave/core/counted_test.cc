#include "engrave/core/counted.h"

#include <gtest/gtest.h>

namespace intaglio {
namespace {

TEST(Counted, OneIsSingularAndEveryOtherCountPlural) {
  EXPECT_EQ(Counted(0, "point"), "0 points");
  EXPECT_EQ(Counted(1, "point"), "1 point");
  EXPECT_EQ(Counted(2, "point"), "2 points");
  EXPECT_EQ(Counted(101, "point"), "101 points");
}

TEST(Counted, APluralOfItsOwnIsTaken) {
  EXPECT_EQ(NounFor(1, "pass", "passes"), "pass");
  EXPECT_EQ(NounFor(3, "pass", "passes"), "passes");
}

TEST(Counted, TheVerbAgrees) {
  EXPECT_STREQ(IsOrAre(1), "is");
  EXPECT_STREQ(IsOrAre(0), "are");
  EXPECT_STREQ(WasOrWere(1), "was");
  EXPECT_STREQ(WasOrWere(2), "were");
  EXPECT_STREQ(HasOrHave(1), "has");
  EXPECT_STREQ(HasOrHave(0), "have");
  EXPECT_STREQ(VerbFor(1, "belongs", "belong"), "belongs");
  EXPECT_STREQ(VerbFor(3, "belongs", "belong"), "belong");
}

}  // namespace
}  // namespace intaglio
