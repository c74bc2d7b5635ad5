// `intaglio galvo` as it is typed, with a head that is traced ray by ray.

#include "services/cli/galvo/galvo_command.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cstdio>
#include <fstream>
#include <random>
#include <set>

#include "engrave/galvo/files/ct5_tables.h"
#include "engrave/render/png_file.h"
#include "services/client/exit_codes.h"
#include "tests/engrave/galvo/traced_head.h"
#include "tests/services/cli/typed_command.h"
#include "tests/test_folder.h"

namespace intaglio::cli {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

class GalvoCommand : public TypedCommand {
 protected:
  int Type(std::vector<std::string> words) {
    words.insert(words.begin(), "galvo");
    return TypeTo(AddGalvoCommand, words);
  }
};

constexpr int kBits = 5184;

/// Where the head marks a target through a correction file, nullptr: with none.
Vec2 MarkedAt(const galvo::WrongField& field, const galvo::Ct5* file,
              const Vec2& target_mm) {
  if (file == nullptr) return field.Arrive(target_mm);
  // As a control board does: bilinear between four nodes of its table, in whole bits.
  const Vec2 node = target_mm * kBits / 4096 + Vec2(128, 128);
  const int i = static_cast<int>(node.x()), j = static_cast<int>(node.y());
  const double u = node.x() - i, v = node.y() - j;
  Vec2 bits;
  for (std::size_t axis = 0; axis < 2; ++axis) {
    const auto at = [&](int x, int y) {
      return static_cast<double>(file->tables[axis][galvo::Ct5::IndexOf(x, y)]);
    };
    bits[static_cast<int>(axis)] =
        std::round((1 - v) * ((1 - u) * at(i, j) + u * at(i + 1, j)) +
                   v * ((1 - u) * at(i, j + 1) + u * at(i + 1, j + 1)));
  }
  return field.Arrive((bits - Vec2(1 << 19, 1 << 19)) / kBits);
}

/// Marks a grid of 9 x 9 and measures it with 5 um of noise.
std::string MeasuredGrid(const galvo::WrongField& field, const galvo::Ct5* file,
                         unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> noise(0, .005);
  std::string text = "command_x_mm,command_y_mm,measured_x_mm,measured_y_mm\n";
  for (int j = -4; j <= 4; ++j) {
    for (int i = -4; i <= 4; ++i) {
      const Vec2 target_mm(12 * i, 12 * j);
      const Vec2 at_mm = MarkedAt(field, file, target_mm);
      text += fmt::format("{},{},{},{}\n", target_mm.x(), target_mm.y(),
                          at_mm.x() + noise(random), at_mm.y() + noise(random));
    }
  }
  return text;
}

double WorstUm(const galvo::WrongField& field, const galvo::Ct5* file) {
  double worst_mm = 0;
  for (int i = -48; i <= 48; ++i) {
    for (int j = -48; j <= 48; ++j) {
      const Vec2 target_mm(i, j);
      worst_mm =
          std::max(worst_mm, (MarkedAt(field, file, target_mm) - target_mm).norm());
    }
  }
  return 1000 * worst_mm;
}

TEST_F(GalvoCommand, CalibrateEndsBelowTenMicrometresOverAHundredMillimetres) {
  const galvo::WrongField field(100, .03, 20);
  const std::string grid = folder_ / "grid.csv", first = folder_ / "first.ct5",
                    second = folder_ / "second.ct5", picture = folder_ / "left.png";
  EXPECT_GT(WorstUm(field, nullptr), 2000);
  std::ofstream(grid) << MeasuredGrid(field, nullptr, 1);
  ASSERT_EQ(Type({"calibrate", grid, "--field", "100", "--bits", "5184", "--out", first,
                  "--picture", picture}),
            client::kExitGood)
      << output_ << errors_;
  EXPECT_THAT(output_, HasSubstr("marks         81, 0 left out"));
  EXPECT_THAT(output_, HasSubstr("surface       none: what is left is chance"));
  EXPECT_THAT(output_, HasSubstr("lens_3_ratio"));
  EXPECT_GT(fs::file_size(picture), 5000U);
  const auto once = galvo::ReadCt5(test::ContentOf(first), first);
  ASSERT_TRUE(once.has_value()) << once.error().message;
  EXPECT_LT(WorstUm(field, &*once), 10);

  // The second round: marks made with the first table prove it, and give another.
  std::ofstream(grid) << MeasuredGrid(field, &*once, 2);
  ASSERT_EQ(
      Type({"calibrate", grid, "--field", "100", "--table", first, "--out", second}),
      client::kExitGood)
      << output_ << errors_;
  EXPECT_THAT(output_, HasSubstr("5184 bit/mm"));
  const auto twice = galvo::ReadCt5(test::ContentOf(second), second);
  ASSERT_TRUE(twice.has_value()) << twice.error().message;
  EXPECT_LT(WorstUm(field, &*twice), 10);
}

TEST_F(GalvoCommand, CalibrateFindsTheMarksOfAScanByThemselves) {
  const galvo::WrongField field(100, .03, 20);
  constexpr double kPixelMm = 0.08;
  render::Canvas scan(1300, 1300);
  render::FillRect(scan, {0, 0, 1300, 1300}, {render::Color{0.8F, 0.8F, 0.8F}});
  const Eigen::Rotation2Dd turn(0.03);  // laid on the scanner a little askew
  for (int j = -4; j <= 4; ++j) {
    for (int i = -4; i <= 4; ++i) {
      const Vec2 at_mm = turn * field.Arrive(Vec2(12 * i, 12 * j));
      // (0.5, 0.5) is the middle of the first pixel.
      render::DrawDisc(scan, Vec2(650 + at_mm.x() / kPixelMm, 650 - at_mm.y() / kPixelMm),
                       5, {render::Color{0.1F, 0.1F, 0.1F}});
    }
  }
  const std::string picture = folder_ / "scan.png", out = folder_ / "scan.ct5";
  ASSERT_TRUE(render::WritePng(picture, scan).has_value());
  ASSERT_EQ(
      Type({"calibrate", picture, "--nodes", "9", "--pitch", "12", "--pixel", "80",
            "--mark-size", "800", "--field", "100", "--bits", "5184", "--out", out}),
      client::kExitGood)
      << output_ << errors_;
  EXPECT_THAT(output_, HasSubstr("grid          81 of 81 nodes found, 0 other spots"));
  const auto table = galvo::ReadCt5(test::ContentOf(out), out);
  ASSERT_TRUE(table.has_value()) << table.error().message;
  // A scan has no place and no turn of its own: those of the head's middle stay.
  double worst_mm = 0;
  const Vec2 middle_mm = MarkedAt(field, &*table, {0, 0});
  const Vec2 right_mm = MarkedAt(field, &*table, {40, 0}) - middle_mm;
  EXPECT_LT(std::abs(right_mm.y()), 0.02);
  for (int i = -48; i <= 48; i += 2) {
    for (int j = -48; j <= 48; j += 2) {
      const Vec2 at_mm = MarkedAt(field, &*table, Vec2(i, j)) - middle_mm;
      const Vec2 upright_mm =
          Eigen::Rotation2Dd(-std::atan2(right_mm.y(), right_mm.x())) * at_mm;
      worst_mm = std::max(worst_mm, (upright_mm - Vec2(i, j)).norm());
    }
  }
  EXPECT_LT(1000 * worst_mm, 10);
  EXPECT_EQ(
      Type({"calibrate", picture, "--nodes", "9", "--pitch", "12", "--field", "100"}),
      client::kExitWrongInput);
  EXPECT_THAT(errors_, HasSubstr("--pixel and --mark-size: are missing"));
}

TEST_F(GalvoCommand, CalibrateNamesWhatIsWrongWithItsInput) {
  const std::string grid = folder_ / "grid.csv";
  std::ofstream(grid) << "command_x_mm,command_y_mm,measured_x_mm\n1,2,3\n";
  EXPECT_EQ(Type({"calibrate", grid, "--field", "100"}), client::kExitWrongInput);
  EXPECT_THAT(errors_, HasSubstr("grid.csv: has no column measured_y_mm"));
  std::ofstream(grid)
      << "command_x_mm,command_y_mm,measured_x_mm,measured_y_mm\n1,2,x,3\n";
  EXPECT_EQ(Type({"calibrate", grid, "--field", "100"}), client::kExitWrongInput);
  EXPECT_THAT(errors_, HasSubstr("grid.csv:2: measured_x_mm \"x\" is no number"));
  std::ofstream(grid) << MeasuredGrid(galvo::WrongField(100, .03, 20), nullptr, 1);
  EXPECT_EQ(Type({"calibrate", grid, "--field", "100", "--out", folder_ / "a.ct5"}),
            client::kExitWrongInput);
  EXPECT_THAT(errors_, HasSubstr("--bits: the calibration of the control"));
  EXPECT_EQ(Type({"calibrate", grid, "--field", "50"}), client::kExitWrongInput);
  EXPECT_THAT(errors_, HasSubstr("grid.csv: mark 1: commanded to (-48, -48) mm"));
  const std::string ctb = folder_ / "old.ctb";
  std::ofstream(ctb) << "x";
  EXPECT_EQ(Type({"calibrate", grid, "--field", "100", "--table", ctb}),
            client::kExitWrongInput);
  EXPECT_THAT(errors_, HasSubstr("old.ctb: does not have its calibration"));
}

constexpr const char* kHoles =
    R"(<svg xmlns="http://www.w3.org/2000/svg" width="16mm" height="16mm" viewBox="0 0 16 16">)"
    R"(<circle cx="2" cy="2" r="0.5"/><circle cx="7" cy="6" r="0.5"/>)"
    R"(<circle cx="3" cy="12" r="0.5"/><circle cx="14" cy="14" r="0.5"/></svg>)";

TEST_F(GalvoCommand, PlanFindsTheLargestSpeedAndNamesWhatIsMissedAboveIt) {
  const std::string drawing = folder_ / "holes.svg", csv = folder_ / "order.csv",
                    picture = folder_ / "web.png";
  std::ofstream(drawing) << kHoles;
  const std::vector<std::string> words = {"plan",         drawing, "--field", "20",
                                          "--repeats",    "5",     "--pitch", "16",
                                          "--mark-speed", "1500"};
  ASSERT_EQ(Type(words), client::kExitGood) << output_ << errors_;
  EXPECT_THAT(output_, HasSubstr("marks         20 in 76 mm of web"));
  double fastest = 0, frames = 0, gain = 0;
  const auto line = output_.find("chosen order");
  ASSERT_NE(line, std::string::npos) << output_;
  ASSERT_EQ(
      std::sscanf(output_.c_str() + line, "chosen order %lf mm/s, %lf", &fastest, &gain),
      2);
  ASSERT_EQ(std::sscanf(output_.c_str() + output_.find("frames "), "frames %lf", &frames),
            1);
  EXPECT_NEAR(fastest / frames, gain, 0.01);
  auto slower = words, faster = words;
  slower.insert(slower.end(), {"--web-speed", fmt::format("{}", 0.99 * fastest), "--csv",
                               csv, "--picture", picture});
  faster.insert(faster.end(), {"--web-speed", fmt::format("{}", 1.02 * fastest)});
  EXPECT_EQ(Type(slower), client::kExitGood) << output_ << errors_;
  EXPECT_THAT(output_, HasSubstr("all marks are made"));
  EXPECT_GT(fs::file_size(picture), 5000U);
  EXPECT_EQ(Type(faster), client::kExitNotGood);
  EXPECT_THAT(output_,
              ::testing::ContainsRegex("of 20 marks (is|are) missed, first contour"));

  // The order by its own table: every mark once, each in the field while it is made.
  std::ifstream in(csv);
  std::string row;
  std::getline(in, row);
  EXPECT_EQ(row, "order,contour,x_mm,y_mm,time_ms,missed");
  std::set<int> contours;
  double now_s = -1e9;
  while (std::getline(in, row)) {
    int order = 0, contour = 0, missed = 0;
    double x = 0, y = 0, ms = 0;
    ASSERT_EQ(std::sscanf(row.c_str(), "%d,%d,%lf,%lf,%lf,%d", &order, &contour, &x, &y,
                          &ms, &missed),
              6)
        << row;
    contours.insert(contour);
    EXPECT_EQ(missed, 0);
    EXPECT_GT(ms, 3.14159 / 1.5 + 0.6 - 0.01);
    // At time t the web has moved x by v t.
    now_s = std::max(now_s, (-9.5 - x) / (0.99 * fastest)) + ms / 1000;
    EXPECT_LE(x + 0.99 * fastest * now_s, 9.5 + 1e-3);
  }
  EXPECT_EQ(contours.size(), 20U);
}

TEST_F(GalvoCommand, PlanRefusesWhatTheFieldDoesNotHold) {
  const std::string drawing = folder_ / "holes.svg";
  std::ofstream(drawing) << kHoles;
  EXPECT_EQ(Type({"plan", drawing, "--field", "10"}), client::kExitWrongInput);
  EXPECT_THAT(errors_, HasSubstr("the field is 10 mm: divide it"));
  EXPECT_EQ(Type({"plan", drawing, "--field", "20", "--repeats", "3"}),
            client::kExitWrongInput);
  EXPECT_THAT(errors_, HasSubstr("--repeats: needs --pitch"));
}

TEST_F(GalvoCommand, TicksAreOutputsOfTheDrawingThroughTheTable) {
  const std::string drawing = folder_ / "holes.svg", csv = folder_ / "ticks.csv",
                    vcd = folder_ / "ticks.vcd";
  std::ofstream(drawing) << kHoles;
  ASSERT_EQ(Type({"ticks", drawing, "--field", "20", "--mark-speed", "500", "--csv", csv,
                  "--capture", vcd}),
            client::kExitGood)
      << output_ << errors_;
  EXPECT_THAT(output_, HasSubstr("strokes       4"));
  EXPECT_THAT(output_, HasSubstr("resolution    0.305 um"));
  std::ifstream in(csv);
  std::string row;
  std::getline(in, row);
  int lit = 0, rows = 0;
  // Middles of the holes from the middle of the drawing, y up.
  const std::vector<Vec2> middles = {{-6, 6}, {-1, 2}, {-5, -4}, {6, -6}};
  while (std::getline(in, row)) {
    int tick = 0, x = 0, y = 0, laser = 0;
    ASSERT_EQ(std::sscanf(row.c_str(), "%d,%d,%d,%d", &tick, &x, &y, &laser), 4) << row;
    ++rows;
    if (laser == 0) continue;
    ++lit;
    const Vec2 at_mm = 20.0 / 65536 * Vec2(x - 32768, y - 32768);
    double from_mm = 1e9;
    for (const Vec2& middle : middles)
      from_mm = std::min(from_mm, std::abs((at_mm - middle).norm() - 0.5));
    EXPECT_LT(from_mm, 0.0015);  // half a step of 0.3 um, chords of 1 um
  }
  // 4 pi mm at 500 mm/s, each hole rounded up to whole ticks.
  EXPECT_NEAR(lit, 2513, 6);
  EXPECT_GT(fs::file_size(vcd), 100U * static_cast<unsigned>(rows));
  EXPECT_EQ(Type({"ticks", drawing, "--field", "10"}), client::kExitWrongInput);
  EXPECT_THAT(errors_, HasSubstr("lit ticks are outside the field of 10 mm"));
  EXPECT_EQ(Type({"ticks", drawing}), client::kExitWrongInput);
  EXPECT_THAT(errors_, HasSubstr("--field: full scale of the outputs"));
}

}  // namespace
}  // namespace intaglio::cli
