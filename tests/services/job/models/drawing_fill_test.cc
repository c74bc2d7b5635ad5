// The fill of a drawing: what a browser shows dark and has no points is a warning.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/services/job/models/one_model.h"

namespace intaglio {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

std::string SvgOf(const std::string& path) {
  return "<svg xmlns='http://www.w3.org/2000/svg' width='20mm' height='20mm' "
         "viewBox='0 0 20 20'><path d='M1 1 L3 1'/><path d='" +
         path + "'/></svg>";
}

/// The warnings of this drawing with a fill that name open curves.
std::vector<std::string> Unfilled(const std::string& path, bool fill) {
  OneModel one;
  one.model.set_file("plate.svg");
  one.model.mutable_curves()->set_fill(fill);
  one.model.mutable_placement()->set_unit_mm(1);
  const JobSpec whole = WithDefaults(one.job, GoodMachine());
  const auto sources = MakeSources(whole, {BytesOf(SvgOf(path))}, {}, {});
  EXPECT_TRUE(sources) << sources.error().message;
  std::vector<std::string> texts;
  if (!sources) return texts;
  for (const Warning& warning : sources->warnings) {
    if (warning.text.find("not filled") != std::string::npos &&
        warning.weight == WarningWeight::kWarning)
      texts.push_back(warning.text);
  }
  return texts;
}

TEST(DrawingFill, OpenCurvesAroundAnAreaAreAWarningWithIt) {
  const auto open = Unfilled("M2 2 H18 V18 H2", true);
  ASSERT_EQ(open.size(), 1U);
  EXPECT_THAT(open[0], AllOf(HasSubstr("plate.svg: 1 of 2 curves is open"),
                             HasSubstr("256 mm2 together")));
}

// Closed by a command or by its end, a line without an area, and without a fill.
TEST(DrawingFill, OthersAreNone) {
  EXPECT_TRUE(Unfilled("M2 2 H18 V18 H2 Z", true).empty());
  EXPECT_TRUE(Unfilled("M2 2 H18 V18 H2 V2", true).empty());
  EXPECT_TRUE(Unfilled("M2 2 L18 18", true).empty());
  EXPECT_TRUE(Unfilled("M2 2 H18 V18 H2", false).empty());
}

}  // namespace
}  // namespace intaglio
