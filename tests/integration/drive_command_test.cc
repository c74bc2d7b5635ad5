// `intaglio drive` as it is typed.

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <google/protobuf/util/json_util.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <map>
#include <numbers>
#include <string>
#include <vector>

#include "proto/drive_report.pb.h"
#include "tests/integration/run_program.h"
#include "tests/test_folder.h"

namespace intaglio {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using ::testing::AllOf;
using testing::Ended;
using ::testing::HasSubstr;

constexpr const char* kProfile =
    INTAGLIO_SOURCE_DIR "/deploy/drives/tirnovean-2016.textproto";

class DriveCommand : public ::testing::Test {
 protected:
  DriveCommand() : folder_(test::FreshFolder()) {}

  Ended Type(std::vector<std::string> words) const {
    words.insert(words.begin(), "drive");
    testing::Running run(testing::Program("intaglio"), words, folder_ / "output.txt");
    return run.WaitForEnd(30s);
  }
  static bool IsPng(const fs::path& file) {
    std::ifstream stream(file, std::ios::binary);
    const std::string bytes{std::istreambuf_iterator<char>(stream), {}};
    return bytes.size() > 1000 && bytes.starts_with("\x89PNG");
  }

  fs::path folder_;
};

TEST_F(DriveCommand, ASuppliedProfileIsFoundByItsName) {
  EXPECT_EQ(Type({"size", "tirnovean-2016", "--json"}).exit_code, 0);
  const Ended unknown = Type({"size", "tirnovan-2016"});
  EXPECT_EQ(unknown.exit_code, 2);
  EXPECT_THAT(unknown.output, HasSubstr("did you mean tirnovean-2016?"));
}

TEST_F(DriveCommand, SizeHasTheNumbersOfTheSource) {
  const Ended size = Type({"size", kProfile, "--source-rules"});
  EXPECT_EQ(size.exit_code, 0) << size.output;
  EXPECT_THAT(size.output,
              AllOf(HasSubstr("screw 0.00149563"), HasSubstr("2307.69 rad/s^2"),
                    HasSubstr("6.63389 Nm"), HasSubstr("the motors bear the demand")));
}

// Zarudnev 2007: the reference's values of one corner, and of figure 2 at 90 degrees, xi
// .3 and 100 mm/s.
TEST_F(DriveCommand, CornerHasTheNumbersOfTheSource) {
  const Ended corner = Type({"corner", "--wx", "150", "--wy", "220"});
  EXPECT_EQ(corner.exit_code, 0) << corner.output;
  for (const char* part :
       {"bandwidth 123.93 rad/s", "formula (6)   2.1649 ms", "x first       1.9188 ms",
        "y first       1.2555 ms", "published     46.19 mm/s for 100 um"})
    EXPECT_THAT(corner.output, HasSubstr(part));
  const Ended figure = Type({"corner", "--figure", "55", "105"});
  EXPECT_EQ(figure.exit_code, 0) << figure.output;
  struct Row {
    int natural_1, natural_2;
    double exact_um, formula_um;
  };
  for (const Row& row :
       {Row{40, 105, 917, 1098}, Row{55, 105, 583, 697}, Row{80, 105, 346, 370},
        Row{105, 105, 248, 202}, Row{140, 105, 265, 286}, Row{200, 105, 305, 365},
        Row{40, 55, 703, 770}, Row{55, 55, 473, 386}, Row{200, 55, 745, 876}}) {
    const std::string head = fmt::format("\n{},{},", row.natural_1, row.natural_2);
    const std::size_t at = figure.output.find(head);
    ASSERT_NE(at, std::string::npos) << head;
    double exact_um = 0, formula_um = 0;
    ASSERT_EQ(std::sscanf(figure.output.c_str() + at + head.size(), "%lf,%lf", &exact_um,
                          &formula_um),
              2);
    EXPECT_NEAR(exact_um, row.exact_um, 0.51) << head;
    EXPECT_NEAR(formula_um, row.formula_um, 0.51) << head;
  }
  const fs::path picture = folder_ / "figure2.png";
  EXPECT_EQ(Type({"corner", "--figure", "105", "--picture", picture.string()}).exit_code,
            0);
  EXPECT_TRUE(IsPng(picture));
  EXPECT_EQ(Type({"corner", "--turn", "180"}).exit_code, 2);
}

// x lags 20 ms and y 24 ms behind, at 50 mm/s on 30 mm; the sum over the directions is 0.
TEST_F(DriveCommand, CircleHasTheLagsOfTheAxes) {
  for (const double direction : {1.0, -1.0}) {
    std::ofstream table(folder_ / (direction > 0 ? "left.csv" : "right.csv"));
    table << "x_mm,y_mm\n";
    for (int i = 0; i < 360; ++i) {
      const double angle = direction * i * std::numbers::pi / 180;
      const double rate = direction * 50.0 / 30;
      table << fmt::format("{:.6f},{:.6f}\n", 30 * std::cos(angle - rate * 0.020),
                           30 * std::sin(angle - rate * 0.024));
    }
  }
  const std::string left = (folder_ / "left.csv").string();
  const std::string right = (folder_ / "right.csv").string();
  const Ended both = Type({"circle", left, "--clockwise", right, "--radius", "30",
                           "--feed", "50", "--tolerance", "20"});
  EXPECT_EQ(both.exit_code, 3) << both.output;
  EXPECT_THAT(both.output, HasSubstr("x -4.0000 ms behind y"));
  EXPECT_THAT(both.output, HasSubstr("verdict       NOT GOOD: 200.00 um of 20 um"));
  EXPECT_EQ(Type({"circle", left, "--radius", "30", "--tolerance", "201"}).exit_code, 0);
  EXPECT_EQ(Type({"circle", kProfile, "--radius", "30"}).exit_code, 2);
}

TEST_F(DriveCommand, TuneGivesEachGainItsReason) {
  const Ended tune = Type({"tune", kProfile, "--regime", "circle"});
  EXPECT_EQ(tune.exit_code, 0) << tune.output;
  EXPECT_THAT(tune.output,
              AllOf(HasSubstr("axis          x"), HasSubstr("axis          y"),
                    HasSubstr("position gain"), HasSubstr("ellipse"),
                    HasSubstr("a circle keeps its radius")));
}

TEST_F(DriveCommand, CompareFindsThePanelThatIsNotStable) {
  const Ended good = Type({"compare", kProfile});
  EXPECT_EQ(good.exit_code, 0) << good.output;
  for (const char* row : {"rapid    panel", "rapid    tuned", "circle   panel",
                          "circle   tuned", "corner   panel", "corner   tuned"})
    EXPECT_THAT(good.output, HasSubstr(row));
  std::string text = testing::TextIn(kProfile);
  for (std::size_t at = 0; (at = text.find("VOLT_PER_MM", at)) != std::string::npos;)
    text.replace(at, 11, "ENCODER_PULSE");
  std::ofstream(folder_ / "pulses.textproto") << text;
  const Ended bad = Type({"compare", (folder_ / "pulses.textproto").string()});
  EXPECT_EQ(bad.exit_code, 3);
  EXPECT_THAT(bad.output,
              AllOf(HasSubstr("NOT STABLE"), HasSubstr("corner   panel    NOT STABLE")));
  const Ended refused = Type({"simulate", (folder_ / "pulses.textproto").string()});
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_THAT(refused.output, HasSubstr("the largest stable one is"));
}

// Each regime has its answer: the tuned gains leave no lag, so that a circle keeps its
// radius and no corner is cut by it; a corner at full speed overshoots instead.
TEST_F(DriveCommand, CompareHasThreeAnswers) {
  const Ended compared = Type({"compare", kProfile, "--json"});
  ASSERT_EQ(compared.exit_code, 0) << compared.output;
  DriveLoops loops;
  ASSERT_TRUE(google::protobuf::util::JsonStringToMessage(compared.output, &loops).ok());
  ASSERT_EQ(loops.answers_size(), 6);
  std::map<std::string, RegimeAnswer> answers;
  for (const RegimeAnswer& answer : loops.answers()) {
    EXPECT_TRUE(answer.simulated()) << answer.regime();
    answers[answer.regime() + " " + answer.gains()] = answer;
  }
  ASSERT_EQ(answers["rapid panel"].rapid_size(), 2);
  for (const RapidAnswer& rapid : answers["rapid tuned"].rapid())
    EXPECT_GE(rapid.settling_ms(), 0);
  EXPECT_LT(answers["corner tuned"].inside_um(), answers["corner panel"].inside_um());
  EXPECT_GT(answers["corner tuned"].outside_um(), 0);
}

TEST_F(DriveCommand, SimulateWritesTableAndPicture) {
  const fs::path table = folder_ / "move.csv", picture = folder_ / "move.png";
  const Ended move = Type({"simulate", kProfile, "--axis", "y", "--length", "20",
                           "--speed", "200", "--acceleration", "1500", "--csv",
                           table.string(), "--picture", picture.string()});
  EXPECT_EQ(move.exit_code, 0) << move.output;
  EXPECT_TRUE(IsPng(picture));
  EXPECT_THAT(testing::TextIn(table), HasSubstr("time_s,setpoint_m,position_m"));
  const Ended step = Type({"simulate", kProfile, "--step", "--length", "0.5", "--ideal",
                           "--picture", picture.string()});
  EXPECT_EQ(step.exit_code, 0) << step.output;
  EXPECT_EQ(Type({"simulate", kProfile, "--axis", "w"}).exit_code, 2);
}

// Tirnovean 2016, ch. 4.6: R 30 mm at 2000 mm/min. With the published gains in V per mm,
// K = 327.5 1/s, each axis lags by F / K = 102 um, and the circle shrinks by it squared
// over twice the radius.
TEST_F(DriveCommand, SimulateTurnsACircleAndACornerOfTwoAxes) {
  const fs::path table = folder_ / "circle.csv", picture = folder_ / "circle.png";
  const Ended circle =
      Type({"simulate", kProfile, "--circle", "30", "--speed", "33.3333", "--ideal",
            "--csv", table.string(), "--picture", picture.string(), "--json"});
  EXPECT_EQ(circle.exit_code, 0) << circle.output;
  DriveCourse course;
  ASSERT_TRUE(google::protobuf::util::JsonStringToMessage(circle.output, &course).ok())
      << circle.output;
  ASSERT_EQ(course.axes_size(), 2);
  EXPECT_EQ(course.axes(0).axis(), "x");
  EXPECT_NEAR(course.axes(0).max_error_um(), 102, 8);
  EXPECT_LT(course.settled_inside_um() + course.settled_outside_um(), 2);
  EXPECT_TRUE(IsPng(picture));
  EXPECT_THAT(testing::TextIn(table), HasSubstr("y_following_error_m"));
  const Ended corner = Type({"simulate", kProfile, "--corner", "90", "--speed", "33.3333",
                             "--load", "1.58", "--ideal"});
  EXPECT_EQ(corner.exit_code, 0) << corner.output;
  EXPECT_THAT(corner.output,
              AllOf(HasSubstr("axis          x: error"),
                    HasSubstr("axis          y: error"), HasSubstr("um inside at most")));
  const Ended both = Type({"simulate", kProfile, "--corner", "90", "--circle", "30"});
  EXPECT_EQ(both.exit_code, 2);
  EXPECT_THAT(both.output, HasSubstr("not both"));
  EXPECT_EQ(Type({"simulate", kProfile, "--corner", "190"}).exit_code, 2);
}

TEST_F(DriveCommand, IdentifyFindsTheDriveOfARecord) {
  // A spring of 80 Hz and 0.4 after a step, sampled every ms.
  const double w = 2 * 3.14159265358979 * 80, d = 0.4;
  const double r = w * std::sqrt(1 - d * d);
  std::ofstream table(folder_ / "record.csv");
  table.precision(15);
  table << "time_s,command,position\n0,0,0\n1e-9,1,0\n";
  for (int i = 1; i < 100; ++i) {
    const double t = i * 0.001;
    table << t << ",1,"
          << 1 - std::exp(-d * w * t) * (std::cos(r * t) + d * w / r * std::sin(r * t))
          << "\n";
  }
  table.close();
  const fs::path picture = folder_ / "found.png";
  const Ended found = Type(
      {"identify", (folder_ / "record.csv").string(), "--picture", picture.string()});
  EXPECT_EQ(found.exit_code, 0) << found.output;
  EXPECT_THAT(found.output,
              AllOf(HasSubstr("natural_frequency_hz     80 +-"),
                    HasSubstr("damping_ratio            0.4 +-"),
                    HasSubstr("second_order { natural_frequency_hz: 80 damping_ratio: "
                              "0.4 }")));
  EXPECT_TRUE(IsPng(picture));
  std::ofstream(folder_ / "bad.csv") << "time_s,command,position\n0,0,x\n";
  const Ended bad = Type({"identify", (folder_ / "bad.csv").string()});
  EXPECT_EQ(bad.exit_code, 2);
  EXPECT_THAT(bad.output, HasSubstr("bad.csv:2: position \"x\" is no number"));
}

}  // namespace
}  // namespace intaglio
