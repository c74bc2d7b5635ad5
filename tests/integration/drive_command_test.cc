// `intaglio drive` as it is typed.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

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

TEST_F(DriveCommand, SizeHasTheNumbersOfTheSource) {
  const Ended size = Type({"size", kProfile, "--source-rules"});
  EXPECT_EQ(size.exit_code, 0) << size.output;
  EXPECT_THAT(size.output,
              AllOf(HasSubstr("screw 0.00149563"), HasSubstr("2307.69 rad/s^2"),
                    HasSubstr("6.63389 Nm"), HasSubstr("the motors bear the demand")));
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
  std::string text = testing::TextIn(kProfile);
  for (std::size_t at = 0; (at = text.find("VOLT_PER_MM", at)) != std::string::npos;)
    text.replace(at, 11, "ENCODER_PULSE");
  std::ofstream(folder_ / "pulses.textproto") << text;
  const Ended bad = Type({"compare", (folder_ / "pulses.textproto").string()});
  EXPECT_EQ(bad.exit_code, 3);
  EXPECT_THAT(bad.output, HasSubstr("NOT STABLE"));
  const Ended refused = Type({"simulate", (folder_ / "pulses.textproto").string()});
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_THAT(refused.output, HasSubstr("the largest stable one is"));
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
