// `intaglio sheet use` and `nest`, from files to figures and files.

#include "services/cli/sheet/sheet_command.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <numbers>

#include "engrave/image/image_file.h"
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

/// A picture of 8 x 4 pixels whose left half is black, as a file of each kind: a BMP of
/// 24 bits and a TIFF of one strip, by their formats.
std::string HalfBlackBmp() {
  std::string file(
      "BM\x96\0\0\0\0\0\0\0\x36\0\0\0\x28\0\0\0\x08\0\0\0\x04\0\0\0"
      "\x01\0\x18\0",
      30);
  file += std::string(24, '\0');
  for (int y = 0; y < 4; ++y) file += std::string(12, '\0') + std::string(12, '\xff');
  return file;
}

std::string HalfBlackTiff() {
  std::string file("II*\0\x08\0\0\0", 8);
  const auto number = [&file](std::uint32_t value, int size) {
    for (int i = 0; i < size; ++i)
      file.push_back(static_cast<char>(value >> 8 * i & 255));
  };
  constexpr std::array<std::array<std::uint32_t, 2>, 8> kFields = {{{256, 8},
                                                                    {257, 4},
                                                                    {258, 8},
                                                                    {259, 1},
                                                                    {262, 1},
                                                                    {273, 110},
                                                                    {278, 4},
                                                                    {279, 32}}};
  number(kFields.size(), 2);
  for (const auto& [tag, value] : kFields)
    number(tag, 2), number(4, 2), number(1, 4), number(value, 4);
  number(0, 4);
  for (int y = 0; y < 4; ++y) file += std::string(4, '\0') + std::string(4, '\xff');
  return file;
}

TEST_F(SheetCommand, UseOfAPictureIsThatOfItsBlackPixelsInAnyFormat) {
  for (const auto& [name, bytes] :
       {std::pair("half.bmp", HalfBlackBmp()), std::pair("half.TIF", HalfBlackTiff())}) {
    ASSERT_EQ(Type({"sheet", "use", Write(name, bytes), "--pixels-per-mm", "2"}),
              client::kExitGood)
        << errors_;
    EXPECT_THAT(output_, HasSubstr("sheet         8.00 mm2")) << name;
    EXPECT_THAT(output_, HasSubstr("use           50.00 %")) << name;
  }
}

TEST_F(SheetCommand, UseRefusesAFileOfAnotherKindByItsName) {
  EXPECT_EQ(Type({"sheet", "use", Write("part.stl", "solid")}), client::kExitWrongInput);
  EXPECT_THAT(errors_, HasSubstr("part.stl: is a mesh; parts and sheets are read from"));
  EXPECT_EQ(Type({"sheet", "use", Write("part.gif", "GIF")}), client::kExitWrongInput);
  EXPECT_THAT(errors_, HasSubstr("part.gif: has an unknown extension; known are:"));
  EXPECT_EQ(Type({"sheet", "use", Write("half.png", "II")}), client::kExitWrongInput);
  EXPECT_THAT(errors_, HasSubstr("half.png: the file is not a PNG, JPEG, TIFF, BMP"));
}

// A plate of half the sheet covers half of the drawn sheet, and its hole is not filled.
TEST_F(SheetCommand, NestedPartsAreShownAsAPicture) {
  const std::string plate = Write(
      "plate.svg",
      R"(<svg xmlns="http://www.w3.org/2000/svg" width="50mm" height="100mm" viewBox="0 0 50 100"><rect width="50" height="100"/><circle cx="25" cy="50" r="10"/></svg>)");
  const std::string file = folder_ / "sheets.png";
  ASSERT_EQ(Type({"sheet", "nest", plate, "--sheet", "100", "100", "--margin", "0",
                  "--gap", "0", "--upright", "--picture", file}),
            client::kExitGood)
      << errors_;
  EXPECT_THAT(output_, HasSubstr("picture       " + file));
  const auto picture = image::ParseImage(test::ContentOf(file));
  ASSERT_TRUE(picture) << picture.error().message;
  const double bright = static_cast<double>(
      std::count_if(picture->samples.begin(), picture->samples.end(),
                    [](std::uint16_t sample) { return sample > 30'000; }));
  // The sheet is drawn with 1320 pixels a side; letters and outlines are thin.
  const double part_share = (5000 - 100 * std::numbers::pi) / 10'000;
  EXPECT_NEAR(bright / (1320.0 * 1320.0), part_share, 0.01);
}

TEST_F(SheetCommand, NestNamesThePartThatDoesNotFit) {
  EXPECT_EQ(Type({"sheet", "nest", Write("parts.svg", NinePlates(false)), "--sheet",
                  "150", "90"}),
            client::kExitWrongInput);
  EXPECT_THAT(errors_, HasSubstr("of 180 x 100 mm does not fit"));
}

}  // namespace
}  // namespace intaglio::cli
