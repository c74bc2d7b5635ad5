// `intaglio sheet use` and `nest`, from files to figures and files.

#include "services/cli/sheet/sheet_command.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <numbers>

#include "services/cli/contour/contour_command.h"
#include "services/client/exit_codes.h"
#include "tests/services/cli/typed_command.h"
#include "tests/test_folder.h"

namespace intaglio::cli {
namespace {

using ::testing::HasSubstr;

class SheetCommand : public TypedCommand {
 protected:
  std::string Write(const std::string& name, const std::string& text) {
    const std::string file = folder_ / name;
    std::ofstream(file) << text;
    return file;
  }
  int Type(const std::vector<std::string>& words) {
    return TypeTo(
        [](command_line::Command root) {
          AddSheetCommand(root);
          AddContourCommand(root);
        },
        words);
  }
  /// Nine plates of 180 x 100 with a square hole of 44: the area of the published
  /// example, 144 576 mm2 of 600 x 400.
  static std::string NinePlates(bool with_sheet) {
    std::string text =
        R"(<svg xmlns="http://www.w3.org/2000/svg" width="600mm" height="400mm" viewBox="0 0 600 400">)";
    if (with_sheet) text += R"(<rect x="0" y="0" width="600" height="400"/>)";
    for (int x = 0; x < 3; ++x) {
      for (int y = 0; y < 3; ++y) {
        text += fmt::format(
            R"(<rect x="{}" y="{}" width="180" height="100"/><rect x="{}" y="{}" width="44" height="44"/>)",
            10 + 195 * x, 20 + 125 * y, 70 + 195 * x, 50 + 125 * y);
      }
    }
    return text + "</svg>";
  }
};

TEST_F(SheetCommand, UseIsThatOfThePublishedExample) {
  ASSERT_EQ(Type({"sheet", "use", Write("plates.svg", NinePlates(true))}),
            client::kExitGood)
      << errors_;
  EXPECT_THAT(output_, HasSubstr("parts         9, 162000.00 mm2"));
  EXPECT_THAT(output_, HasSubstr("holes         9, 17424.00 mm2"));
  EXPECT_THAT(output_, HasSubstr("use           60.24 %"));
  ASSERT_EQ(Type({"sheet", "use", Write("parts.svg", NinePlates(false)), "--sheet", "600",
                  "400"}),
            client::kExitGood)
      << errors_;
  EXPECT_THAT(output_, HasSubstr("use           60.24 %"));
}

TEST_F(SheetCommand, UseRefusesASheetThatIsTooSmallOrMissing) {
  const std::string parts = Write("parts.svg", NinePlates(false));
  EXPECT_EQ(Type({"sheet", "use", parts, "--sheet", "500", "400"}),
            client::kExitWrongInput);
  EXPECT_THAT(errors_, HasSubstr("of 570 x 350 mm does not lie within a sheet of 500"));
  EXPECT_EQ(Type({"sheet", "use", parts}), client::kExitWrongInput);
  EXPECT_THAT(errors_, HasSubstr("9 contours are outermost"));
}

// Eighteen plates of 180 x 100 with gaps of 2 and margins of 5: three columns and three
// rows a sheet upright, and what is written is cut along the same lengths.
TEST_F(SheetCommand, NestedPartsAreADrawingThatIsCut) {
  const std::string parts = Write("parts.svg", NinePlates(false));
  const std::string out = folder_ / "nested.svg";
  ASSERT_EQ(Type({"sheet", "nest", parts, "--sheet", "600", "400", "--copies", "2",
                  "--upright", "--out", out}),
            client::kExitGood)
      << errors_;
  EXPECT_THAT(output_, HasSubstr("parts         18 on 2 sheets of 600 x 400 mm"));
  EXPECT_THAT(output_, HasSubstr("use           60.24 %"));
  for (const std::string& sheet : {out, std::string(folder_ / "nested_2.svg")}) {
    ASSERT_EQ(Type({"contour", sheet, "--make", "cut", "--tool", "1"}), client::kExitGood)
        << errors_;
    // Nine holes of 44 with corners, nine plates with round ones of 0.5 mm.
    const double length_mm = 9 * (4 * 43 + 2 * (180 + 100) + std::numbers::pi);
    EXPECT_THAT(output_,
                HasSubstr(fmt::format("contours      18, {:.1f} mm at work", length_mm)));
  }
  ASSERT_EQ(Type({"sheet", "use", out, "--sheet", "600", "400"}), client::kExitGood)
      << errors_;
  EXPECT_THAT(output_, HasSubstr("use           60.24 %"));
}

TEST_F(SheetCommand, NestNamesThePartThatDoesNotFit) {
  EXPECT_EQ(Type({"sheet", "nest", Write("parts.svg", NinePlates(false)), "--sheet",
                  "150", "90"}),
            client::kExitWrongInput);
  EXPECT_THAT(errors_, HasSubstr("of 180 x 100 mm does not fit"));
}

}  // namespace
}  // namespace intaglio::cli
