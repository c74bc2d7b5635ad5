// A test pulse, a focus series, lamp and shutter by hand, through the product's processes
// and a virtual engraver.

#include <cmath>

#include "tests/integration/teach_shop.h"

namespace intaglio {
namespace {

using namespace std::chrono_literals;
using testing::Ended;
using testing::Eventually;
using ::testing::HasSubstr;
using testing::Program;
using testing::Running;

constexpr double kHeightMm = 30;

class TeachFocus : public testing::TeachShop {
 protected:
  /// A job of `teach pulse` or `teach focus`, armed and made.
  void Make(std::vector<std::string> words) {
    words.insert(words.end(), {"--block", "50", "50", "30", "--materials",
                               (folder_ / "materials.db").string()});
    const Ended ended = Teach(words);
    ASSERT_EQ(ended.exit_code, 0) << ended.output;
    EXPECT_THAT(ended.output, HasSubstr("intaglio arm "));
    const std::string job = NumberIn(ended.output);
    ASSERT_TRUE(Eventually(
        [&] {
          shown_ = Type({"show", job}).output;
          return shown_.find("state      waiting for arm") != std::string::npos;
        },
        60s))
        << shown_;
    const auto before = Cracks().size();
    EXPECT_FALSE(Eventually([&] { return Cracks().size() > before; }, 2s))
        << "it fires without an arm";
    Type({"arm", job});
    ASSERT_TRUE(RunsTo(job, "done")) << shown_;
  }
  std::string Panel() { return testing::AskPanel(shop(), "status"); }
};

TEST_F(TeachFocus, ATestPulseIsWhereTheFocusIs) {
  // 2 mm of air below the face, by the zero of the profile.
  Do({"move", "12", "17", "28", "--speed", "50"});
  Make({"pulse", "--out", (folder_ / "pulse").string()});
  const auto cracks = Cracks();
  ASSERT_EQ(cracks.size(), 1u);
  // The beam model of the virtual engraver, N-BK7 at 532 nm, a beam of 5 mm in a lens of
  // 43 mm.
  constexpr double kAperture = 5.0 / 2 / 43;
  const double glass_per_stage = std::sqrt((1.51947 * 1.51947 - kAperture * kAperture) /
                                           (1 - kAperture * kAperture));
  const Vec3 expected(12, 17, kHeightMm - 2 * glass_per_stage);
  EXPECT_LT((cracks[0].position_mm - expected).norm(), 0.003)
      << cracks[0].position_mm.transpose();
}

// 30 mJ are the energy of a job by default; a test pulse has a tenth of it.
TEST_F(TeachFocus, ATestPulseIsWeakerThanAJobs) {
  Do({"move", "12", "17", "20", "--speed", "50"});
  Make({"pulse", "--out", (folder_ / "weak").string()});
  Do({"move", "14", "17", "20", "--speed", "50"});
  Make({"pulse", "--energy", "2", "--out", (folder_ / "asked").string()});
  Do({"move", "16", "17", "20", "--speed", "50"});
  Make({"pulse", "--energy", "30", "--out", (folder_ / "full").string()});
  const auto cracks = Cracks();
  ASSERT_EQ(cracks.size(), 3u);
  // The splitter gives the channel a quarter. The laser's stability: 2 %.
  EXPECT_NEAR(4 * cracks[0].pulse_energy_mj, 3, 0.06);
  EXPECT_NEAR(4 * cracks[1].pulse_energy_mj, 2, 0.04);
  EXPECT_NEAR(4 * cracks[2].pulse_energy_mj, 30, 0.6);
  // By the cube root of the energy, in whole um.
  const double full_mm = cracks[2].length_mm;
  EXPECT_GT(full_mm, 0.1);
  EXPECT_NEAR(cracks[0].length_mm, full_mm * std::cbrt(0.1), 0.003);
  EXPECT_NEAR(cracks[1].length_mm, full_mm * std::cbrt(1.0 / 15), 0.003);
}

// lamp_hold_s of the profile is 300.
TEST_F(TeachFocus, TheLampStaysOnAfterAJobUntilAStop) {
  EXPECT_FALSE(StatusNow().lamp_on());
  Do({"move", "12", "17", "20", "--speed", "50"});
  Make({"pulse", "--out", (folder_ / "pulse").string()});
  EXPECT_FALSE(Eventually([&] { return !StatusNow().lamp_on(); }, 2s));
  EXPECT_EQ(StatusNow().shutters_open_size(), 0);
  EXPECT_EQ(Type({"stop", "els-03"}).exit_code, 0);
  EXPECT_TRUE(Eventually([&] { return !StatusNow().lamp_on(); }, 10s));
  EXPECT_EQ(Type({"stop", "els-03", "--reset"}).exit_code, 0);
}

// The laser's controller keeps each stop latched, also of its own button.
TEST_F(TeachFocus, AMachineWithoutAJobIsMovedByHandBehindTheResetOfItsStop) {
  Do({"move", "12", "17", "20", "--speed", "50"});
  EXPECT_EQ(Type({"stop", "els-03"}).exit_code, 0);
  EXPECT_NE(Teach({"move", "13", "17", "20", "--speed", "50"}).exit_code, 0);
  EXPECT_EQ(Type({"stop", "els-03", "--reset"}).exit_code, 0);
  Do({"move", "13", "17", "20", "--speed", "50"});
  testing::AskPanel(shop(), "estop press");
  EXPECT_TRUE(Eventually([&] { return !StatusNow().stop_released(); }, 10s));
  const Ended held = Type({"stop", "els-03", "--reset"});
  EXPECT_EQ(held.exit_code, 4) << held.output;
  EXPECT_THAT(held.output, HasSubstr("its own stop button is pressed"));
  testing::AskPanel(shop(), "estop release");
  const Ended latched = Teach({"move", "14", "17", "20", "--speed", "50"});
  EXPECT_THAT(latched.output, HasSubstr("then `intaglio stop --reset`"));
  const Ended reset = Type({"stop", "els-03", "--reset"});
  EXPECT_EQ(reset.exit_code, 0) << reset.output;
  Do({"move", "14", "17", "20", "--speed", "50"});
  EXPECT_EQ(StatusNow().shutters_open_size(), 0);
  EXPECT_TRUE(Cracks().empty());
}

// The zero is 0.5 mm too high. What the series teaches moves the next job's cracks by
// exactly that, and they are within half a step of where they belong.
TEST_F(TeachFocus, AFocusSeriesTeachesTheZeroInZ) {
  const std::string out = (folder_ / "focus").string();
  Do({"zero", "--lens", "f43", "--by", "0", "0", "0.5"});
  Do({"move", "12", "17", "29", "--speed", "50"});
  Make({"pulse", "--out", (folder_ / "before").string()});
  const double before_mm = Cracks().at(0).position_mm.z();
  Make({"focus", "--out", out, "--step", "0.1"});
  const auto cracks = Cracks();
  ASSERT_EQ(cracks.size(), 21u);
  // As a microscope shows them: from the start of the row.
  std::vector<formats::GlassCrack> row(cracks.begin() + 1, cracks.end());
  std::sort(row.begin(), row.end(), [](const auto& a, const auto& b) {
    return a.position_mm.x() < b.position_mm.x();
  });
  std::size_t first = 0;
  while (first < row.size() && !row[first].in_glass) ++first;
  ASSERT_GT(first, 1u) << "the series began in the glass";
  ASSERT_LT(first, row.size());
  const Ended taught = Teach({"focus", "--out", out, "--first", std::to_string(first + 1),
                              "--materials", (folder_ / "materials.db").string()});
  ASSERT_EQ(taught.exit_code, 0) << taught.output;

  const double ratio = std::sqrt(0.96) / std::sqrt(1.51947 * 1.51947 - 0.04);
  const double step_mm = 0.1;
  // The point under the same axes is not the same point of the block: the same job.
  const Ended again = Type({"submit", (folder_ / "before/job.textproto").string(),
                            "--machine", (shop() / "machine.textproto").string()});
  const std::string job = NumberIn(again.output);
  Eventually([&] { return Type({"arm", job}).exit_code == 0; }, 60s);
  ASSERT_TRUE(RunsTo(job, "done")) << shown_;
  const auto all = Cracks();
  ASSERT_EQ(all.size(), 22u);
  const double moved_mm = all.back().position_mm.z() - before_mm;
  const double taught_mm = -(static_cast<double>(first + 1) - 0.5) * step_mm;
  EXPECT_NEAR(moved_mm, taught_mm, 0.003) << "in the glass, of which k cancels";
  // 0.5 mm of air too high is 0.5 / k of glass.
  EXPECT_NEAR(moved_mm, -0.5 / ratio, step_mm / 2 + 0.003);
}

TEST_F(TeachFocus, LampAndShutterAreOnWhileTheyAreHeldAndNoLonger) {
  EXPECT_THAT(Do({"lamp", "--for", "1"}), HasSubstr("the lamp is on"));
  EXPECT_TRUE(Eventually([&] { return !StatusNow().lamp_on(); }, 5s));
  EXPECT_THAT(Do({"shutter", "2", "--for", "1"}),
              HasSubstr("the shutter of channel 2 is open"));
  EXPECT_TRUE(Eventually([&] { return StatusNow().shutters_open_size() == 0; }, 5s));
  EXPECT_TRUE(Cracks().empty());
}

TEST_F(TeachFocus, AKilledClientAndAnOpenDoorSwitchLampAndShutterOff) {
  const auto is_open = [&] { return StatusNow().shutters_open_size() == 1; };
  std::unique_ptr<Running> client;
  // On a computer that is too busy the machine lets go; the operator holds it again.
  const auto holds_open = [&](const char* file) {
    for (int i = 0; i < 10; ++i) {
      client = std::make_unique<Running>(Program("intaglio"),
                                         With({"teach", "shutter", "1"}), folder_ / file);
      bool open = false;
      Eventually([&] { return (open = is_open()) || !client->running(); }, 20s);
      if (open) return true;
    }
    return false;
  };
  ASSERT_TRUE(holds_open("killed.txt")) << client->Output();
  client->Signal(SIGKILL);
  EXPECT_TRUE(Eventually([&] { return !is_open(); }, 10s));
  Ended ended;
  for (int i = 0; i < 10; ++i) {
    ASSERT_TRUE(holds_open("door.txt")) << client->Output();
    const bool locked = StatusNow().door_locked();
    const std::string opened = testing::AskPanel(shop(), "door open");
    testing::AskPanel(shop(), "door force");
    EXPECT_TRUE(Eventually([&] { return !is_open(); }, 10s));
    EXPECT_FALSE(StatusNow().door_locked());
    ended = client->WaitForEnd(10s);
    EXPECT_EQ(ended.exit_code, 4) << ended.output;
    if (EndsByABusyComputer(ended)) {
      testing::AskPanel(shop(), "door close");
      continue;
    }
    EXPECT_TRUE(locked);
    EXPECT_THAT(opened, HasSubstr("the door is locked"));
    break;
  }
  EXPECT_THAT(ended.output, HasSubstr("door is open"));
  testing::AskPanel(shop(), "door close");
  EXPECT_FALSE(Eventually(is_open, 3s)) << "it opens by itself";
}

TEST_F(TeachFocus, NothingIsLitByHandWhileAJobFires) {
  const std::string job = Submit({"--rate", "5", "--arm"});
  ASSERT_TRUE(RunsTo(job, "engraving")) << shown_;
  ASSERT_TRUE(Eventually([&] { return Cracks().size() > 3; }, 60s));
  for (const std::vector<std::string>& words :
       {std::vector<std::string>{"lamp", "--for", "1"}, {"shutter", "2", "--for", "1"}}) {
    const Ended refused = Teach(words);
    EXPECT_EQ(refused.exit_code, 4) << refused.output;
  }
  const auto count = Cracks().size();
  EXPECT_TRUE(Eventually([&] { return Cracks().size() > count; }, 20s));
  Type({"cancel", job});
}

}  // namespace
}  // namespace intaglio
