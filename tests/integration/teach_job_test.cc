// Teaching through the product's processes and a virtual engraver: what was taught is
// where the next job's cracks lie, and where the stage is before and after it.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <regex>
#include <string>
#include <thread>
#include <utility>

#include "tests/integration/teach_shop.h"

namespace intaglio {
namespace {

using namespace std::chrono_literals;
using testing::Ended;
using testing::Eventually;
using ::testing::HasSubstr;

class TeachJob : public testing::TeachShop {
 protected:
  using testing::TeachShop::TeachShop;
  std::string Panel() { return testing::AskPanel(shop(), "status"); }
  /// Where the stage is by the record of the virtual engraver itself; NaN: no answer.
  Vec3 Stage() {
    std::smatch at;
    const std::string panel = Panel();
    static const std::regex kPlace(R"("stage_mm": \[([^,]+), ([^,]+), ([^\]]+)\])");
    if (!std::regex_search(panel, at, kPlace)) return Vec3::Constant(std::nan(""));
    return {std::stod(at[1]), std::stod(at[2]), std::stod(at[3])};
  }
  bool StageIsAt(const Vec3& place) { return (Stage() - place).norm() < 0.002; }
  bool LampIsOn() {
    std::smatch bits;
    const std::string panel = Panel();
    EXPECT_TRUE(std::regex_search(panel, bits, std::regex("\"interlocks\": ([0-9]+)")));
    return !bits.empty() && (std::stoul(bits[1]) & kLampOn) != 0;
  }

  void Signal(const std::string& program, int number) const {
    const auto pids = testing::ProcessesWith({program, shop().string()});
    EXPECT_EQ(pids.size(), 1u) << program;
    for (const pid_t pid : pids) ::kill(pid, number);
  }
  void SetSynchronizer(int number) const { Signal("intaglio-synchronizer", number); }

 private:
  static constexpr unsigned long kLampOn = 1 << 3;  // docs/protocols.md, LaserStatus
};

/// How much further the focus goes in the glass than the stage, by Snell's law at the
/// marginal ray (engrave/optics/focus.h has it the other way round).
double GlassPerStage(double index, double aperture) {
  return std::sqrt(index * index - aperture * aperture) /
         std::sqrt(1 - aperture * aperture);
}

class TeachZero : public TeachJob {
 protected:
  /// How far the cracks behind the first `count` are from those moved by `by` of the
  /// stage, mm: each from the nearest.
  double FarthestFromFirst(std::size_t count, const Vec3& by) {
    const auto all = Cracks();
    if (all.size() != 2 * count) {
      ADD_FAILURE() << all.size() << " cracks";
      return 1e9;
    }
    // The beam model of the virtual engraver, N-BK7 at 532 nm.
    const Vec3 expected(by.x(), by.y(), by.z() * GlassPerStage(1.51947, 5.0 / 2 / 43));
    double farthest_mm = 0;
    for (std::size_t before = 0; before < count; ++before) {
      double nearest_mm = 1e9;
      for (std::size_t i = count; i < all.size(); ++i) {
        const Vec3 moved = all[i].position_mm - all[before].position_mm - expected;
        nearest_mm = std::min(nearest_mm, moved.norm());
      }
      farthest_mm = std::max(farthest_mm, nearest_mm);
    }
    return farthest_mm;
  }

  const Vec3 by_{0.4, -0.3, -0.2};
  const std::vector<std::string> move_zero_ = {"zero", "--lens", "f43", "--by",
                                               "0.4",  "-0.3",   "-0.2"};
};

// Cracks of both jobs come in the same order, for only their places differ.
TEST_F(TeachZero, MovesTheNextJobsCracksByExactlyThat) {
  ASSERT_TRUE(RunsTo(Submit({"--arm"}), "done")) << shown_;
  const std::size_t count = Cracks().size();
  ASSERT_GT(count, 100U);
  const Ended taught = Teach(move_zero_);
  ASSERT_EQ(taught.exit_code, 0) << taught.output;
  EXPECT_THAT(taught.output, HasSubstr("version 1"));
  ASSERT_TRUE(RunsTo(Submit({"--arm"}), "done")) << shown_;
  // What the compensation of the drive leaves, below 1 um in each job.
  EXPECT_LT(FarthestFromFirst(count, by_), 0.003);
  Do({"undo"});
  EXPECT_EQ(testing::TextIn(shop() / "machine.textproto").find("zeros"),
            std::string::npos);
}

TEST_F(TeachZero, IsUsedByTheFirstArmOfAJobThatWaited) {
  ASSERT_TRUE(RunsTo(Submit({"--arm"}), "done")) << shown_;
  const std::size_t count = Cracks().size();
  ASSERT_GT(count, 100U);
  const std::string job = Submit();
  ASSERT_TRUE(RunsTo(job, "waiting for arm")) << shown_;
  ASSERT_EQ(Teach(move_zero_).exit_code, 0);
  Type({"arm", job});
  ASSERT_TRUE(RunsTo(job, "done")) << shown_;
  EXPECT_LT(FarthestFromFirst(count, by_), 0.003);
}

TEST_F(TeachZero, InAPauseRefusesTheArmUntilItIsBroughtBack) {
  const std::string job = Submit({"--rate", "5", "--arm"});  // for a minute
  ASSERT_TRUE(RunsTo(job, "engraving")) << shown_;
  ASSERT_TRUE(Eventually([&] { return Cracks().size() > 3; }, 60s));
  ASSERT_EQ(Type({"pause", job}).exit_code, 0);
  ASSERT_TRUE(Eventually([&] { return Teach(move_zero_).exit_code == 0; }, 30s));
  const std::size_t made = Cracks().size();
  Type({"resume", job});
  EXPECT_TRUE(Eventually(
      [&] {
        shown_ = Type({"show", job}).output;
        return shown_.find("the zero of channel 1") != std::string::npos;
      },
      30s))
      << shown_;
  EXPECT_EQ(Cracks().size(), made) << "with another zero than it was begun with";
  Do({"undo"});
  EXPECT_TRUE(Eventually(
      [&] {
        Type({"resume", job});
        return Cracks().size() > made;
      },
      60s))
      << Type({"show", job}).output;
  Type({"cancel", job});
}

// The stage waits at the sample position for the lamp: long enough to be seen there.
class TeachJobWithASlowLamp : public TeachJob {
 protected:
  TeachJobWithASlowLamp() : TeachJob(20) {}
};

// By the record of the virtual engraver itself: stage and lamp are where they were until
// somebody arms, and while the next job waits behind one that was made.
TEST_F(TeachJobWithASlowLamp, AJobThatIsSubmittedMovesAndLightsNothingBeforeItIsArmed) {
  const Vec3 sample(20, 30, 40), park(60, 50, 45), before(5, 5, 35);
  Do({"move", "20", "30", "40", "--speed", "50"});
  Do({"sample"});
  Do({"move", "60", "50", "45", "--speed", "50"});
  Do({"park"});
  Do({"move", "5", "5", "35", "--speed", "50"});
  const std::string job = Submit();
  ASSERT_TRUE(RunsTo(job, "waiting for arm")) << shown_;
  EXPECT_FALSE(Eventually([&] { return !StageIsAt(before) || LampIsOn(); }, 5s))
      << Panel();
  Type({"arm", job});
  EXPECT_TRUE(Eventually([&] { return StageIsAt(sample); }, 30s)) << Logs();
  EXPECT_TRUE(LampIsOn()) << Panel();
  ASSERT_TRUE(RunsTo(job, "done")) << shown_;
  EXPECT_TRUE(Eventually([&] { return StageIsAt(park); }, 30s)) << Logs();
  EXPECT_EQ(Logs().find("position_not_reached"), std::string::npos);
  const std::string next = Submit();
  ASSERT_TRUE(RunsTo(next, "waiting for arm")) << shown_;
  EXPECT_FALSE(Eventually([&] { return !StageIsAt(park); }, 3s)) << Panel();
  Type({"cancel", next});
}

TEST_F(TeachJob, ADriveToTheSamplePositionEndsWithItsGrantAndBeginsWithTheNext) {
  const Vec3 before(5, 5, 35), sample(90, 90, 40);
  Do({"move", "90", "90", "40", "--speed", "50"});
  Do({"sample"});
  Do({"move", "5", "5", "35", "--speed", "50"});
  const std::string job = Submit({"--arm"});
  ASSERT_TRUE(Eventually([&] { return !StageIsAt(before); }, 30s)) << Logs();
  ASSERT_NE(testing::AskPanel(shop(), "door open"), "");
  ASSERT_FALSE(StageIsAt(sample)) << "the door was opened too late";
  testing::AskPanel(shop(), "door close");
  // Nothing of it comes back by itself.
  Vec3 rests = Stage();
  const auto has_come_to_rest = [&] {
    rests = Stage();
    return !Eventually([&] { return !StageIsAt(rests); }, 500ms);
  };
  ASSERT_TRUE(Eventually(has_come_to_rest, 10s));
  EXPECT_FALSE(Eventually([&] { return !StageIsAt(rests); }, 2s)) << Panel();
  EXPECT_TRUE(RunsTo(job, "done")) << shown_;
  EXPECT_EQ(Logs().find("position_not_reached"), std::string::npos);
}

TEST_F(TeachJob, APositionThatIsNotReachedIsAnAlarmAndTheJobGoesOn) {
  Do({"move", "60", "60", "40", "--speed", "50"});
  Do({"sample"});
  Do({"move", "5", "5", "35", "--speed", "50"});
  const std::string job = Submit();
  ASSERT_TRUE(RunsTo(job, "waiting for arm")) << shown_;
  ASSERT_NE(testing::AskPanel(shop(), "stick x"), "");
  Type({"arm", job});
  ASSERT_TRUE(Eventually(
      [&] { return Logs().find("position_not_reached") != std::string::npos; }, 30s))
      << Logs();
  EXPECT_THAT(Logs(), HasSubstr("the taught sample position was not reached"));
  testing::AskPanel(shop(), "unstick");
  EXPECT_TRUE(RunsTo(job, "done")) << shown_;
}

// As just after a start, or where a busy computer gives the synchronizer no time: the
// command waits for key and door, and moves when they are known to be closed.
TEST_F(TeachJob, AMoveWaitsForTheReportOfKeyAndDoor) {
  Do({"move", "5", "5", "35", "--speed", "50"});
  SetSynchronizer(SIGSTOP);
  std::jthread goes_on([this] {
    std::this_thread::sleep_for(1500ms);
    SetSynchronizer(SIGCONT);
  });
  const Ended moved = Teach({"move", "8", "5", "35", "--speed", "50"});
  EXPECT_EQ(moved.exit_code, 0) << moved.output;
  EXPECT_THAT(moved.output, HasSubstr("it is tried again for 3 s"));
  EXPECT_TRUE(StageIsAt(Vec3(8, 5, 35))) << Panel();
}

TEST_F(TeachJob, AMoveIsRefusedWhereKeyAndDoorStayUnknown) {
  Do({"move", "5", "5", "35", "--speed", "50"});
  SetSynchronizer(SIGSTOP);
  const Ended moved = Teach({"move", "8", "5", "35", "--speed", "50"});
  SetSynchronizer(SIGCONT);
  EXPECT_EQ(moved.exit_code, 4) << moved.output;
  EXPECT_THAT(moved.output, HasSubstr("key and door are not known"));
  EXPECT_FALSE(Eventually([&] { return !StageIsAt(Vec3(5, 5, 35)); }, 2s)) << Panel();
}

// An arm that came before the first answer of the laser controller would be spent by it,
// because nobody watched key and door until then.
TEST_F(TeachJob, AnArmWaitsForTheLaserController) {
  const std::string job = Submit();
  ASSERT_TRUE(RunsTo(job, "waiting for arm")) << shown_;
  Signal("virtual-engraver", SIGSTOP);
  ASSERT_TRUE(Eventually(
      [&] {
        return Type({"status"}).output.find("LASER LINE DOWN") != std::string::npos;
      },
      20s))
      << Type({"status"}).output;
  std::jthread goes_on([this] {
    std::this_thread::sleep_for(1500ms);
    Signal("virtual-engraver", SIGCONT);
  });
  const Ended armed = Type({"arm", job});
  EXPECT_EQ(armed.exit_code, 0) << armed.output;
  EXPECT_THAT(armed.output, HasSubstr("the laser controller does not answer"));
  EXPECT_TRUE(RunsTo(job, "done")) << shown_;
}

TEST_F(TeachJob, NothingIsMovedOrTaughtByHandWhileAJobFires) {
  const std::string job = Submit({"--rate", "5", "--arm"});  // for a minute
  ASSERT_TRUE(RunsTo(job, "engraving")) << shown_;
  ASSERT_TRUE(Eventually([&] { return Cracks().size() > 3; }, 60s));
  const Ended jog = Teach({"jog", "x", "1"});
  EXPECT_NE(jog.exit_code, 0);
  EXPECT_THAT(jog.output, ::testing::AnyOf(HasSubstr("a job moves the stage"),
                                           HasSubstr("a job is armed")));
  const Ended zero = Teach({"zero", "--lens", "f43"});
  EXPECT_NE(zero.exit_code, 0) << zero.output;
  EXPECT_EQ(testing::TextIn(shop() / "machine.textproto").find("taught"),
            std::string::npos);
  const auto count = Cracks().size();
  EXPECT_TRUE(Eventually([&] { return Cracks().size() > count; }, 20s))
      << "the job goes on: " << Type({"show", job}).output;
  Type({"cancel", job});
}

}  // namespace
}  // namespace intaglio
