#include "tests/walls/counts.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "tests/test_folder.h"

namespace intaglio::walls {
namespace {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

TEST(Counts, AgreeWithTheirNounsInThisTree) {
  EXPECT_THAT(BareCountsBelow(INTAGLIO_SOURCE_DIR), IsEmpty());
}

TEST(Counts, ACountBeforeAPluralIsFoundWithItsLine) {
  EXPECT_THAT(BareCounts("int a;\nf(\"{} of {} points are lost\", 1, 1);\n"),
              ElementsAre("2: {} points"));
  EXPECT_THAT(BareCounts("f(\"\\\"{:>8} stray ticks\");"),
              ElementsAre("1: {:>8} stray ticks"));
  EXPECT_THAT(BareCounts("f(\"first {} \"\n  \"rays, {0} rows\");"),
              ElementsAre("1: {} rays", "1: {0} rows"));
}

TEST(Counts, UnitsRatesLimitsAndPreconditionsAreNone) {
  for (const char* source : {"f(\"{} mm, {} s, {} ticks/s, {} points/mm^2, {} bytes\");",
                             "f(\"more than {} points; divide it\");",
                             "f(\"it has {} points, more than the {} allowed\");",
                             "f(\"a grid of {} x {} points\");", "// \"{} points\"\n",
                             "Require(a == b, \"{} points have {} masks\", a, b);"}) {
    EXPECT_THAT(BareCounts(source), IsEmpty()) << source;
  }
}

TEST(Counts, AFileIsNamed) {
  const fs::path root = test::FreshFolder();
  fs::create_directories(root / "services/cell");
  std::ofstream(root / "services/cell/a.cc") << "auto a = \"{} cracks\";\n";
  EXPECT_THAT(BareCountsBelow(root),
              ElementsAre(HasSubstr("services/cell/a.cc:1: {} cracks")));
}

}  // namespace
}  // namespace intaglio::walls
