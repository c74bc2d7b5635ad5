// `intaglio galvo grid` as it is typed: the job of the grid, and what `calibrate` takes
// from the profile.

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <map>
#include <numbers>
#include <set>
#include <sstream>

#include "engrave/galvo/head_model.h"
#include "services/cli/galvo/galvo_command.h"
#include "services/cli/marks/marks_command.h"
#include "services/client/exit_codes.h"
#include "tests/engrave/galvo/traced_head.h"
#include "tests/services/cli/typed_command.h"
#include "tests/test_folder.h"

namespace intaglio::cli {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

constexpr const char* kGalvoProfile =
    INTAGLIO_SOURCE_DIR "/deploy/machines/galvo.textproto";

class GalvoGrid : public TypedCommand {
 protected:
  int Type(std::vector<std::string> words) {
    words.insert(words.begin(), "galvo");
    return TypeTo(AddGalvoCommand, words);
  }
  /// The supplied profile, whose correction is this file.
  fs::path ProfileWith(const fs::path& correction) const {
    std::string text = test::ContentOf(kGalvoProfile);
    text.replace(text.find("scan_head {"), 11,
                 "scan_head { correction_file: \"" + correction.string() + "\"");
    std::ofstream(folder_ / "corrected.textproto") << text;
    return folder_ / "corrected.textproto";
  }
  /// 9 x 9 marks that were commanded so, as a field with an error has them.
  template <typename Field>
  fs::path Measured(const Field& field) const {
    std::ofstream out(folder_ / "measured.csv");
    out << "command_x_mm,command_y_mm,measured_x_mm,measured_y_mm\n";
    for (int j = -4; j <= 4; ++j) {
      for (int i = -4; i <= 4; ++i) {
        const Vec2 at_mm = field.Arrive(Vec2(12 * i, 12 * j));
        out << fmt::format("{},{},{},{}\n", 12 * i, 12 * j, at_mm.x(), at_mm.y());
      }
    }
    return folder_ / "measured.csv";
  }
};

/// In steps of 10 um, as a key.
std::pair<long, long> RoundedPlace(double x_mm, double y_mm) {
  return {std::lround(100 * x_mm), std::lround(100 * y_mm)};
}

TEST_F(GalvoGrid, TheJobMarksADiscAtEachNodeAndOneThatShowsTheDirection) {
  const fs::path out = folder_ / "grid";
  ASSERT_EQ(Type({"grid", "--machine", kGalvoProfile, "--out", out.string()}),
            client::kExitGood)
      << errors_;
  EXPECT_EQ(output_, (out / "grid.textproto").string() + "\n");
  EXPECT_THAT(errors_, HasSubstr("9 x 9 discs of 300 um, 12 mm apart"));
  EXPECT_THAT(errors_, HasSubstr("marked without a correction"));
  EXPECT_THAT(errors_, HasSubstr("--nodes 9 --pitch 12 --mark-size 300"));
  // What the queue makes of it: each mark lies in a disc of 0.3 mm.
  const fs::path csv = folder_ / "marks.csv";
  ASSERT_EQ(
      TypeTo(AddMarksCommand, {"marks", "preview", (out / "grid.textproto").string(),
                               "--csv", csv.string()}),
      client::kExitGood)
      << errors_;
  std::istringstream rows(test::ContentOf(csv));
  std::string row;
  std::getline(rows, row);
  ASSERT_THAT(row, HasSubstr("x_mm,y_mm"));
  const auto columns = [](const std::string& line) {
    std::vector<std::string> fields(1);
    for (const char c : line) {
      if (c == ',') {
        fields.emplace_back();
      } else {
        fields.back() += c;
      }
    }
    return fields;
  };
  const auto names = columns(row);
  const auto x_at = std::find(names.begin(), names.end(), "x_mm") - names.begin();
  const auto y_at = std::find(names.begin(), names.end(), "y_mm") - names.begin();
  std::map<std::pair<long, long>, std::set<std::string>> marks_of;
  while (std::getline(rows, row)) {
    const auto fields = columns(row);
    const Vec2 at_mm(std::stod(fields.at(static_cast<std::size_t>(x_at))),
                     std::stod(fields.at(static_cast<std::size_t>(y_at))));
    Vec2 middle_mm = 12 * Vec2((at_mm / 12).array().round());
    if ((at_mm - Vec2(6, 3)).norm() < 0.2) middle_mm = {6, 3};
    EXPECT_LE((at_mm - middle_mm).norm(), 0.15 + 2e-4) << row;  // six digits
    EXPECT_LE(middle_mm.cwiseAbs().maxCoeff(), 48);
    marks_of[RoundedPlace(middle_mm.x(), middle_mm.y())].insert(fields.front());
  }
  EXPECT_EQ(marks_of.size(), 82u);
  // Nine lines or so, and the circle.
  for (const auto& [place, marks] : marks_of) EXPECT_GE(marks.size(), 9u);
}

TEST_F(GalvoGrid, TheTableHasTheCommandsForWhoeverMeasures) {
  ASSERT_EQ(Type({"grid", "--machine", kGalvoProfile, "--nodes", "5", "--pitch", "20",
                  "--out", (folder_ / "grid").string()}),
            client::kExitGood)
      << errors_;
  const std::string table = test::ContentOf(folder_ / "grid/grid.csv");
  EXPECT_THAT(table, HasSubstr("command_x_mm,command_y_mm,measured_x_mm,measured_y_mm\n"
                               "-40,-40,,\n-20,-40,,\n"));
  EXPECT_EQ(std::count(table.begin(), table.end(), '\n'), 26);
  // A line that is not filled in is named.
  EXPECT_EQ(Type({"calibrate", (folder_ / "grid/grid.csv").string(), "--machine",
                  kGalvoProfile}),
            client::kExitWrongInput);
  EXPECT_THAT(errors_, HasSubstr("grid.csv:2: measured_x_mm \"\" is no number; leave the "
                                 "line out when the mark was not found"));
}

TEST_F(GalvoGrid, RefusesWhatIsNoGridOrExceedsTheField) {
  const std::string out = (folder_ / "grid").string();
  const auto grid = [&](std::vector<std::string> more) {
    more.insert(more.begin(), {"grid", "--out", out});
    return Type(more);
  };
  EXPECT_EQ(grid({"--machine", kGalvoProfile, "--pitch", "13"}), client::kExitWrongInput);
  EXPECT_THAT(errors_, HasSubstr("is 104.3 mm wide, and the field 100 mm; give a smaller "
                                 "pitch"));
  EXPECT_EQ(grid({"--machine", kGalvoProfile, "--nodes", "8"}), client::kExitWrongInput);
  EXPECT_THAT(errors_,
              HasSubstr("a grid of 8 nodes a side; give an odd number of 5..65"));
  EXPECT_EQ(grid({"--machine", kGalvoProfile, "--mark-size", "3000"}),
            client::kExitWrongInput);
  EXPECT_THAT(errors_, HasSubstr("a disc may be a fifth of the pitch, 2400 um"));
  EXPECT_EQ(grid({"--machine", INTAGLIO_SOURCE_DIR "/deploy/machines/els-03.textproto"}),
            client::kExitWrongInput);
  EXPECT_THAT(errors_, HasSubstr("its profile has no scan_head"));
  EXPECT_FALSE(fs::exists(out));
}

TEST_F(GalvoGrid, CalibrateTakesFieldAndCorrectionOfTheProfile) {
  const galvo::WrongField field(100, .03, 20);
  const fs::path first = folder_ / "first.ct5";
  ASSERT_EQ(Type({"calibrate", Measured(field).string(), "--machine", kGalvoProfile,
                  "--out", first.string()}),
            client::kExitGood)
      << errors_;
  EXPECT_THAT(output_, HasSubstr("first.ct5, 5243 bit/mm"));
  EXPECT_THAT(errors_, HasSubstr("Use it: scan_head { correction_file: \"" +
                                 first.string() + "\" }"));
  // Marks that a corrected machine makes where they were to be.
  const fs::path profile = ProfileWith(first);
  ASSERT_EQ(
      Type({"grid", "--machine", profile.string(), "--out", (folder_ / "grid").string()}),
      client::kExitGood)
      << errors_;
  EXPECT_THAT(errors_, HasSubstr("marked with the correction " + first.string()));
  std::ofstream right(folder_ / "right.csv");
  right << "command_x_mm,command_y_mm,measured_x_mm,measured_y_mm\n";
  for (int j = -4; j <= 4; ++j)
    for (int i = -4; i <= 4; ++i)
      right << fmt::format("{0},{1},{0},{1}\n", 12 * i, 12 * j);
  right.close();
  ASSERT_EQ(Type({"calibrate", (folder_ / "right.csv").string(), "--machine",
                  profile.string()}),
            client::kExitGood)
      << errors_;
  EXPECT_THAT(output_, HasSubstr("in use        " + first.string()));
  double rms_um = 1e9, largest_um = 1e9;
  ASSERT_EQ(std::sscanf(output_.c_str() + output_.find("field  "),
                        "field %lf um rms, %lf", &rms_um, &largest_um),
            2)
      << output_;
  // The table is linear between nodes 0.8 mm apart, in steps of 0.2 um.
  EXPECT_LT(largest_um, 2);
  EXPECT_EQ(Type({"calibrate", Measured(field).string()}), client::kExitWrongInput);
  EXPECT_THAT(errors_, HasSubstr("--field: is missing"));
  EXPECT_EQ(Type({"calibrate", Measured(field).string(), "--machine",
                  INTAGLIO_SOURCE_DIR "/deploy/machines/els-03.textproto"}),
            client::kExitWrongInput);
  EXPECT_THAT(errors_, HasSubstr("has no scan_head"));
}

TEST_F(GalvoGrid, CoversThatOfTheFieldWhichACorrectionOfAShrunkOneReaches) {
  constexpr double kBorderRad = 20 * std::numbers::pi / 180;
  auto shrunk = galvo::HeadModel::Ideal(50 / kBorderRad);
  shrunk.lens_ratio[1] = -0.03 / (kBorderRad * kBorderRad);
  const fs::path first = folder_ / "first.ct5";
  ASSERT_EQ(Type({"calibrate", Measured(shrunk).string(), "--machine", kGalvoProfile,
                  "--out", first.string()}),
            client::kExitGood)
      << errors_;
  const std::string profile = ProfileWith(first).string();
  const auto grid = [&](std::vector<std::string> more) {
    more.insert(more.begin(),
                {"grid", "--machine", profile, "--out", (folder_ / "grid").string()});
    return Type(more);
  };
  ASSERT_EQ(grid({"--pitch", "12"}), client::kExitWrongInput);
  EXPECT_THAT(errors_, HasSubstr("is 96.3 mm wide, and the field 90.9"));
  ASSERT_EQ(grid({}), client::kExitGood) << errors_;
  // 96 % of it; before this the profile's field.
  EXPECT_THAT(errors_, HasSubstr("9 x 9 discs of 300 um, 10.9"));
  ASSERT_EQ(TypeTo(AddMarksCommand,
                   {"marks", "preview", (folder_ / "grid/grid.textproto").string()}),
            client::kExitGood)
      << errors_;
  EXPECT_THAT(output_, HasSubstr("100 mm, with its correction a square of 90.9"));
}

}  // namespace
}  // namespace intaglio::cli
