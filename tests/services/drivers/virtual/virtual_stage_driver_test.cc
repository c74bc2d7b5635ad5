#include "services/drivers/virtual/virtual_stage_driver.h"

#include <gtest/gtest.h>

#include <functional>
#include <random>

#include "services/drivers/motion_drivers.h"
#include "tests/integration/run_program.h"
#include "tests/services/drivers/fake_stage.h"
#include "tests/test_folder.h"

namespace intaglio::drivers {
namespace {

using namespace std::chrono_literals;

MachineSpec MachineAt(const std::string& device) {
  MachineSpec machine;
  machine.mutable_motion_line()->set_protocol("virtual-stage");
  machine.mutable_motion_line()->set_device(device);
  machine.mutable_motion_line()->set_baud(115200);
  return machine;
}

class VirtualStageDriver : public ::testing::Test {
 protected:
  static constexpr std::uint32_t kCapacity = 100;

  VirtualStageDriver()
      : device(test::FreshFolder() / "motion"),
        stage(device, kCapacity),
        driver(MakeMotionDriver(MachineAt(device)).value()) {}

  bool Until(const std::function<bool()>& condition,
             std::chrono::milliseconds bound = 3s) {
    return intaglio::testing::Eventually(
        [&] {
          driver->Poll();
          stage.Poll();
          return condition();
        },
        bound);
  }
  /// The line is up and the stage has sent its status.
  bool Connect() {
    return Until([&] {
      return driver->state().link_up && driver->state().fault == intaglio_MOTION_OK;
    });
  }
  /// Polls without an aim.
  void Settle(std::chrono::milliseconds time) {
    (void)Until([] { return false; }, time);
  }

  std::filesystem::path device;
  FakeStage stage;
  std::unique_ptr<MotionDriver> driver;
};

motion::Segment SegmentTo(double x_mm) {
  motion::Segment segment;
  segment.end_position_mm = Vec3(x_mm, 0, 0);
  segment.duration_subticks = motion::kSubticksPerTick;
  return segment;
}

TEST_F(VirtualStageDriver, IsDownUntilTheStageAnswers) {
  EXPECT_FALSE(driver->state().link_up);
  EXPECT_EQ(driver->state().fault, intaglio_MOTION_LINK_LOST);
  EXPECT_EQ(driver->Room(), 0u);
  EXPECT_FALSE(driver->BeginRun(1, 10, 0).has_value());
  EXPECT_FALSE(driver->AbortRun().has_value());
  driver->Poll();
  EXPECT_FALSE(driver->state().message.empty()) << "says what it waits for";
  stage.status.tick = 77;
  stage.status.x_nm = 1234567;
  stage.status.vz_counts = -2000000;
  stage.status.covered_through_tick = 99;
  stage.status.following_error_max_nm = 1500;
  ASSERT_TRUE(Connect());
  const DriverState& state = driver->state();
  EXPECT_EQ(state.tick, 77u);
  EXPECT_NEAR(state.position_mm.x(), 1.234567, 1e-12);
  EXPECT_NEAR(state.velocity_mm_s.z(), -2, 1e-12);
  EXPECT_EQ(state.covered_through_tick, 99u);
  EXPECT_NEAR(state.following_error_max_um, 1.5, 1e-12);
  EXPECT_TRUE(state.at_rest);
  EXPECT_TRUE(state.message.empty());
}

TEST_F(VirtualStageDriver, KnowsTheToleranceOfAControllerThatReportsIt) {
  ASSERT_TRUE(Connect());
  EXPECT_EQ(driver->state().position_tolerance_um, 0) << "this one does not";
  stage.Send(link::MotionFrame::kStageTolerance, Encode(link::StageTolerance{10500}));
  EXPECT_TRUE(Until([&] { return driver->state().position_tolerance_um == 10.5; }));
}

// Otherwise a segment of a run ends it, with a piece half made.
TEST_F(VirtualStageDriver, RefusesAControllerThatStepsAnAxisMoreSlowlyThanTheProfile) {
  MachineSpec machine = MachineAt(device);
  machine.mutable_x()->set_max_speed_mm_s(80);
  machine.mutable_y()->set_max_speed_mm_s(40);
  driver = MakeMotionDriver(machine).value();
  ASSERT_TRUE(Connect());
  const link::StageSpeed enough{80000000, 80000000, 40000000};
  stage.Send(link::MotionFrame::kStageSpeed, Encode(enough));
  Settle(50ms);
  EXPECT_TRUE(driver->state().link_up);
  const link::StageSpeed less{79500000, 80000000, 40000000};
  stage.Send(link::MotionFrame::kStageSpeed, Encode(less));
  ASSERT_TRUE(Until([&] { return !driver->state().link_up; }));
  EXPECT_EQ(driver->state().fault, intaglio_MOTION_WRONG_CONTROLLER);
  EXPECT_EQ(driver->state().message,
            "x.max_speed_mm_s: 80 mm/s is faster than the stage controller can step this "
            "axis; reduce it to at most 79.5 mm/s in the machine profile");
  EXPECT_FALSE(driver->BeginRun(1, 10, 0).has_value());
  EXPECT_FALSE(driver->Jog(Vec3(1, 0, 0), 5).has_value());
}

TEST_F(VirtualStageDriver, SendsTimesToAClockOfItsOwnAndCountsTicksItself) {
  stage.clock = 4711;
  ASSERT_TRUE(Connect());
  EXPECT_EQ(driver->state().clock, 4711u);
  ASSERT_TRUE(driver->BeginRun(7, 1000, 123456789).has_value());
  motion::Segment half = SegmentTo(1), whole = SegmentTo(2);
  half.duration_subticks /= 2;
  whole.pulse = true;
  std::vector<motion::Segment> segments;
  std::vector<std::uint64_t> end_ns;
  for (int i = 0; i < 10; ++i) {
    segments.push_back(i % 2 == 0 ? half : whole);
    end_ns.push_back(200000000u + 1000000u * static_cast<std::uint64_t>(i));
  }
  ASSERT_TRUE(Until([&] { return driver->Room() >= 10; }));
  EXPECT_LE(driver->Room(), link::kMaxTimedSegments);
  ASSERT_TRUE(driver->Append(segments, end_ns).has_value());
  // Five times a half and a whole.
  ASSERT_TRUE(Until([&] { return driver->state().covered_through_tick == 1007; }));
  EXPECT_TRUE(stage.begun.empty());
  ASSERT_EQ(stage.timed_begun.size(), 1u);
  EXPECT_EQ(stage.timed_begun[0].start_ns, 123456789u);
  ASSERT_EQ(stage.timed_segments.size(), 10u);
  EXPECT_EQ(stage.timed_segments[3].end_ns, 203000000u);
  EXPECT_EQ(stage.timed_segments[3].x_nm, 2000000);
  EXPECT_TRUE(stage.timed_segments[3].pulse);
  EXPECT_FALSE(stage.out_of_order);
}

TEST_F(VirtualStageDriver, HandsOverPositionsWithTheirTimes) {
  stage.clock = 4711;
  ASSERT_TRUE(Connect());
  stage.Send(
      link::MotionFrame::kTimedPositions,
      Encode(link::TimedPositions{3, 50, {{777, 1000000, 0, 0}, {888, 0, 0, -1}}}));
  std::vector<LatchedPositions> latched;
  ASSERT_TRUE(Until([&] {
    for (auto& entry : driver->TakePositions()) latched.push_back(std::move(entry));
    return !latched.empty();
  }));
  EXPECT_EQ(latched[0].first_tick, 50u);
  EXPECT_EQ(latched[0].at_ns, (std::vector<std::uint64_t>{777, 888}));
  ASSERT_EQ(latched[0].positions_mm.size(), 2u);
  EXPECT_NEAR(latched[0].positions_mm[0].x(), 1, 1e-12);
}

TEST_F(VirtualStageDriver, ReportsSegmentsInNanometres) {
  ASSERT_TRUE(Connect());
  ASSERT_TRUE(driver->BeginRun(7, 1234, 0).has_value());
  motion::Segment first = SegmentTo(12.3456785);
  first.end_position_mm.y() = -0.0000014;
  first.end_velocity_mm_s = Vec3(80, -0.5, 1e-6);
  first.duration_subticks = 98765;
  first.pulse = true;
  motion::Segment last = SegmentTo(170);
  last.program_end = true;
  ASSERT_TRUE(driver->Append(std::vector{first, last}, {}).has_value());
  ASSERT_TRUE(Until([&] { return stage.all_segments.size() == 2; }));
  ASSERT_EQ(stage.begun.size(), 1u);
  EXPECT_EQ(stage.begun[0].run, 7u);
  EXPECT_EQ(stage.begun[0].start_tick, 1234u);
  const link::WireSegment& wire = stage.all_segments[0];
  EXPECT_NEAR(wire.x_nm, 12345678.5, 0.51);
  EXPECT_EQ(wire.y_nm, -1);
  EXPECT_EQ(wire.vx_counts, 80000000);
  EXPECT_EQ(wire.vy_counts, -500000);
  EXPECT_EQ(wire.vz_counts, 1);
  EXPECT_EQ(wire.duration_subticks, 98765u);
  EXPECT_TRUE(wire.pulse);
  EXPECT_FALSE(wire.program_end);
  EXPECT_FALSE(stage.all_segments[1].pulse);
  EXPECT_TRUE(stage.all_segments[1].program_end);
  EXPECT_FALSE(stage.out_of_order);
}

// Mirrors pass points at 8 m/s: 1 nm/s in 32 bits would be another velocity.
TEST_F(VirtualStageDriver, CountsVelocitiesInTheUnitOfTheController) {
  stage.velocity_unit_nm_s = 100;
  ASSERT_TRUE(Connect());
  stage.status.vx_counts = 20000000;
  ASSERT_TRUE(driver->BeginRun(7, 1234, 0).has_value());
  motion::Segment segment = SegmentTo(12);
  segment.end_velocity_mm_s = Vec3(8000, -11000, 0.0001);
  ASSERT_TRUE(driver->Append(std::vector{segment}, {}).has_value());
  ASSERT_TRUE(Until([&] { return stage.all_segments.size() == 1; }));
  EXPECT_EQ(stage.all_segments[0].vx_counts, 80000000);
  EXPECT_EQ(stage.all_segments[0].vy_counts, -110000000);
  EXPECT_EQ(stage.all_segments[0].vz_counts, 1);
  ASSERT_TRUE(Until([&] { return driver->state().velocity_mm_s.x() == 2000; }));
}

TEST_F(VirtualStageDriver, RefusesAVelocityThatTheLineCannotCarry) {
  ASSERT_TRUE(Connect());
  ASSERT_TRUE(driver->BeginRun(7, 1234, 0).has_value());
  motion::Segment segment = SegmentTo(12);
  segment.end_velocity_mm_s = Vec3(0, -8000, 0);
  EXPECT_FALSE(driver->Append(std::vector{segment}, {}).has_value());
  ASSERT_TRUE(Until([&] { return stage.aborts == 1; }));
  EXPECT_TRUE(stage.all_segments.empty());
  EXPECT_FALSE(driver->state().link_up);
  EXPECT_EQ(
      driver->state().message,
      "the plan needs a velocity of 8000 mm/s, and 2147.48 mm/s is the largest that "
      "the stage controller takes on its line: reduce max_speed_mm_s of the axes in "
      "the machine profile");
}

TEST_F(VirtualStageDriver, StopsWhereTheQueueIsFull) {
  ASSERT_TRUE(Connect());
  ASSERT_TRUE(driver->BeginRun(1, 10, 0).has_value());
  std::size_t appended = 0;
  const auto feed = [&] {
    while (const std::size_t room = driver->Room()) {
      EXPECT_LE(room, link::kMaxSegments);
      const std::vector<motion::Segment> part(room, SegmentTo(1));
      ASSERT_TRUE(driver->Append(part, {}).has_value());
      appended += room;
    }
  };
  ASSERT_TRUE(Until([&] { return feed(), stage.all_segments.size() == kCapacity; }));
  for (int i = 0; i < 20; ++i) {
    feed();
    driver->Poll();
    stage.Poll();
  }
  EXPECT_EQ(appended, kCapacity) << "not one more without a word of the stage";
  stage.queue.erase(stage.queue.begin(), stage.queue.begin() + 5);
  stage.SendStatus();
  ASSERT_TRUE(Until([&] { return driver->Room() > 0; }));
  EXPECT_EQ(driver->Room(), 5u);
}

TEST_F(VirtualStageDriver, NeverOverfillsAQueueWhoseReportsAreLate) {
  stage.answers_status = false;  // statuses come when the stage likes
  ASSERT_TRUE(Until([&] { return driver->state().link_up; }));
  stage.SendStatus();
  ASSERT_TRUE(Connect());
  constexpr int kSegments = 3000;
  ASSERT_TRUE(driver->BeginRun(1, 10, 0).has_value());
  std::mt19937 random(5);
  int appended = 0;
  // The whole job: append what there is room for; the stage executes and speaks at
  // random.
  ASSERT_TRUE(Until(
      [&] {
        for (int i = 0; i < 20; ++i) {
          const auto room = static_cast<int>(driver->Room());
          const int count =
              std::min({room, kSegments - appended, 1 + static_cast<int>(random() % 40)});
          std::vector<motion::Segment> part;
          for (int k = 0; k < count; ++k) part.push_back(SegmentTo(0.001 * appended++));
          if (!part.empty() && !driver->Append(part, {})) ADD_FAILURE() << appended;
          driver->Poll();
          stage.Poll();
          const std::size_t executed =
              std::min<std::size_t>(stage.queue.size(), random() % 50);
          stage.queue.erase(stage.queue.begin(),
                            stage.queue.begin() + static_cast<std::ptrdiff_t>(executed));
          if (random() % 3 == 0) stage.SendStatus();
        }
        return stage.all_segments.size() == kSegments;
      },
      10s));
  EXPECT_FALSE(stage.overflowed);
  EXPECT_FALSE(stage.out_of_order);
  for (int i = 0; i < kSegments; ++i)
    ASSERT_EQ(stage.all_segments[static_cast<std::size_t>(i)].x_nm, i * 1000);
}

TEST_F(VirtualStageDriver, ANewRunCountsItsSegmentsAnew) {
  ASSERT_TRUE(Connect());
  for (std::uint32_t run = 1; run <= 3; ++run) {
    ASSERT_TRUE(driver->BeginRun(run, 10 * run, 0).has_value());
    ASSERT_TRUE(Until([&] { return driver->Room() >= 20; })) << run;
    ASSERT_TRUE(
        driver->Append(std::vector<motion::Segment>(20, SegmentTo(1)), {}).has_value());
    ASSERT_TRUE(Until([&] { return stage.all_segments.size() == 20 * run; }));
    stage.queue.clear();
  }
  EXPECT_FALSE(stage.out_of_order);
}

TEST_F(VirtualStageDriver, PassesAbortAndResetOn) {
  ASSERT_TRUE(Connect());
  ASSERT_TRUE(driver->AbortRun().has_value());
  ASSERT_TRUE(Until([&] { return stage.aborts == 1; }));
  EXPECT_EQ(stage.resets, 0);
  ASSERT_TRUE(driver->ClearFault().has_value());
  ASSERT_TRUE(Until([&] { return stage.resets == 1; }));
  EXPECT_EQ(stage.aborts, 1);
}

TEST_F(VirtualStageDriver, ReportsEveryFaultInASentence) {
  using link::StageFault;
  ASSERT_TRUE(Connect());
  struct Case {
    StageFault sent;
    intaglio_MotionFault fault;
  };
  for (const Case& c :
       {Case{StageFault::kStarved, intaglio_MOTION_STARVED},
        Case{StageFault::kLimit, intaglio_MOTION_LIMIT},
        Case{StageFault::kFollowingError, intaglio_MOTION_FOLLOWING_ERROR},
        Case{StageFault::kLate, intaglio_MOTION_LATE},
        Case{StageFault::kRunRefused, intaglio_MOTION_LATE},
        Case{StageFault::kSafeState, intaglio_MOTION_STARVED},
        Case{StageFault::kNoAir, intaglio_MOTION_NO_AIR},
        Case{StageFault::kAirReturned, intaglio_MOTION_SAFE_STATE},
        Case{StageFault::kBlockPlace, intaglio_MOTION_SAFE_STATE},
        Case{StageFault::kPlaceLost, intaglio_MOTION_SAFE_STATE},
        Case{StageFault::kNoSwitch, intaglio_MOTION_SAFE_STATE},
        Case{StageFault::kSwitchStuck, intaglio_MOTION_SAFE_STATE},
        Case{StageFault::kSwitchMet, intaglio_MOTION_SAFE_STATE},
        Case{StageFault::kDriveFault, intaglio_MOTION_SAFE_STATE},
        Case{StageFault::kStopPressed, intaglio_MOTION_SAFE_STATE},
        Case{StageFault::kTooFast, intaglio_MOTION_LIMIT},
        Case{StageFault::kBadSequence, intaglio_MOTION_STARVED}}) {
    const std::uint64_t number = driver->state().number;
    stage.status.fault = c.sent;
    stage.SendStatus();
    ASSERT_TRUE(Until([&] { return driver->state().number > number; }));
    EXPECT_EQ(driver->state().fault, c.fault);
    EXPECT_GT(driver->state().message.size(), 20u);
    EXPECT_TRUE(driver->state().link_up) << "the line is not the fault";
  }
}

TEST_F(VirtualStageDriver, MovesAStageWithoutAPlaceByHomeAlone) {
  ASSERT_TRUE(Connect());
  stage.status.place_lost = true;
  stage.status.fault = link::StageFault::kNoSwitch;
  stage.status.fault_axes = {false, true, false};
  stage.SendStatus();
  ASSERT_TRUE(Until([&] { return !driver->state().homed; }));
  EXPECT_NE(driver->state().message.find("the switch of y was not met"),
            std::string::npos)
      << driver->state().message;
  stage.status.fault = link::StageFault::kNone;
  stage.SendStatus();
  ASSERT_TRUE(Until([&] { return driver->state().fault == intaglio_MOTION_OK; }));
  const auto jogged = driver->Jog(Vec3(1, 0, 0), 1);
  ASSERT_FALSE(jogged.has_value());
  EXPECT_NE(jogged.error().message.find("teach home"), std::string::npos);
  EXPECT_TRUE(driver->Home().has_value());
}

TEST_F(VirtualStageDriver, HandsLatchedPositionsOverInOrder) {
  ASSERT_TRUE(Connect());
  stage.Send(link::MotionFrame::kPositions,
             Encode(link::Positions{3, 50, {{1000000, -2000000, 1}, {1500000, 0, 0}}}));
  stage.Send(link::MotionFrame::kPositions,
             Encode(link::Positions{3, 52, {{2000000, 0, 0}}}));
  std::vector<LatchedPositions> got;
  ASSERT_TRUE(Until([&] {
    for (auto& positions : driver->TakePositions()) got.push_back(std::move(positions));
    return got.size() == 2;
  }));
  EXPECT_EQ(got[0].run, 3u);
  EXPECT_EQ(got[0].first_tick, 50u);
  ASSERT_EQ(got[0].positions_mm.size(), 2u);
  EXPECT_LT((got[0].positions_mm[0] - Vec3(1, -2, 1e-6)).norm(), 1e-12);
  EXPECT_EQ(got[1].first_tick, 52u);
}

TEST_F(VirtualStageDriver, ASilentStageIsALostLine) {
  ASSERT_TRUE(Connect());
  const std::uint64_t number = driver->state().number;
  const auto silent_from = std::chrono::steady_clock::now();
  ASSERT_TRUE(intaglio::testing::Eventually(
      [&] { return driver->Poll(), !driver->state().link_up; }, 2s));
  EXPECT_GT(std::chrono::steady_clock::now() - silent_from, 200ms);
  EXPECT_EQ(driver->state().fault, intaglio_MOTION_LINK_LOST);
  EXPECT_NE(driver->state().message.find("motion line"), std::string::npos);
  EXPECT_GT(driver->state().number, number);
  EXPECT_EQ(driver->Room(), 0u);
  EXPECT_FALSE(driver->Append(std::vector{SegmentTo(1)}, {}).has_value());
  // And it comes back by itself.
  ASSERT_TRUE(Connect());
}

TEST_F(VirtualStageDriver, AnUnpluggedLineIsOpenedAgain) {
  ASSERT_TRUE(Connect());
  ASSERT_TRUE(driver->BeginRun(1, 10, 0).has_value());
  ASSERT_TRUE(driver->Append(std::vector{SegmentTo(1)}, {}).has_value());
  Settle(20ms);
  stage.Unplug();
  ASSERT_TRUE(Until([&] { return !driver->state().link_up; }));
  EXPECT_EQ(driver->state().fault, intaglio_MOTION_LINK_LOST);
  EXPECT_EQ(driver->Room(), 0u);
  EXPECT_EQ(driver->fd(), -1);
  stage.status.fault = link::StageFault::kSafeState;
  stage.Plug();
  ASSERT_TRUE(Until([&] { return driver->state().fault == intaglio_MOTION_STARVED; }));
  EXPECT_TRUE(driver->state().link_up);
}

TEST(MotionDrivers, AnUnknownOneNamesWhatThereIs) {
  for (const char* protocol : {"", "Virtual-Laser", "Virtual-Stage"}) {
    MachineSpec machine;
    machine.mutable_motion_line()->set_protocol(protocol);
    const auto driver = MakeMotionDriver(machine);
    ASSERT_FALSE(driver.has_value()) << protocol;
    EXPECT_EQ(driver.error().code, ErrorCode::kUnsupported);
    EXPECT_EQ(driver.error().value, protocol);
    EXPECT_NE(driver.error().message.find("virtual-stage"), std::string::npos);
    EXPECT_NE(driver.error().message.find("motion_line.protocol"), std::string::npos);
  }
}

TEST(MotionDrivers, ADeviceThatCannotBeIsRefusedAtOnce) {
  for (const auto& [device, why] :
       {std::pair("", "is missing; give"), std::pair("udp:1", "no known kind of line"),
        std::pair("tcp:laser-box:5", "not resolved")}) {
    const auto driver = MakeMotionDriver(MachineAt(device));
    ASSERT_FALSE(driver.has_value()) << device;
    EXPECT_NE(driver.error().message.find("motion_line.device: "), std::string::npos);
    EXPECT_NE(driver.error().message.find(why), std::string::npos)
        << driver.error().message;
  }
}

TEST(MotionDrivers, ADeviceThatIsNotThereIsReportedInTheState) {
  auto driver = MakeMotionDriver(MachineAt("/nonexistent/motion"));
  ASSERT_TRUE(driver.has_value());
  (*driver)->Poll();
  EXPECT_FALSE((*driver)->state().link_up);
  EXPECT_NE((*driver)->state().message.find("/nonexistent/motion"), std::string::npos);
}

}  // namespace
}  // namespace intaglio::drivers
