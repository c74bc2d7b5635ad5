// `intaglio galvo` as it is typed, with a head that is traced ray by ray.

#include "services/cli/galvo/galvo_command.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <random>

#include "engrave/galvo/files/ct5_tables.h"
#include "services/client/exit_codes.h"
#include "tests/engrave/galvo/traced_head.h"
#include "tests/test_folder.h"

namespace intaglio::cli {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

class GalvoCommand : public ::testing::Test {
 protected:
  int Type(std::vector<std::string> words) {
    words.insert(words.begin(), "galvo");
    command_line::Program program("intaglio", "");
    AddGalvoCommand(program.root());
    const auto parsed = program.Parse(words);
    EXPECT_TRUE(parsed) << (parsed ? "" : parsed.error().message);
    ::testing::internal::CaptureStdout();
    ::testing::internal::CaptureStderr();
    const int code = program.Run();
    output_ = ::testing::internal::GetCapturedStdout();
    errors_ = ::testing::internal::GetCapturedStderr();
    return code;
  }

  fs::path folder_ = test::FreshFolder();
  std::string output_, errors_;
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

}  // namespace
}  // namespace intaglio::cli
