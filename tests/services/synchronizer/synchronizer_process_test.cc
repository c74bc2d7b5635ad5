// intaglio-synchronizer as a process, between the bus and a virtual engraver.

#include <gmock/gmock.h>

#include <fstream>
#include <limits>
#include <memory>
#include <optional>
#include <regex>
#include <thread>

#include "engrave/formats/point_file.h"
#include "services/cell/journal_writer.h"
#include "services/job/files/job_file.h"
#include "services/platform/bus/bus.h"
#include "services/platform/bus/samples.h"
#include "services/platform/host/safety/stop_latch.h"
#include "services/synchronizer/job_folder.h"
#include "services/synchronizer/pulses/cell_names.h"
#include "tests/services/platform/bus/private_bus.h"
#include "tests/services/platform/host/stage/stage_shop.h"
#include "tests/services/virtual_engraver/engraver_process.h"
#include "tests/services/virtual_engraver/taken_line.h"
#include "tests/test_folder.h"

namespace intaglio::synchronizer {
namespace {

using intaglio::testing::Running;
using test::Eventually;
using ::testing::AllOf;
using ::testing::HasSubstr;
using namespace std::chrono_literals;

const std::string kCell = "els-03";

class SynchronizerProcess : public ::testing::Test {
 protected:
  SynchronizerProcess()
      : folder_(test::FreshFolder()),
        engraver_(folder_,
                  "laser { rates_hz: [1, 2, 5, 10, 25, 50, 100, 200] door_lock: true"
                  "        outputs: 3 inputs: [true, false] }"
                  "stage { travel_min_mm { x: -2 y: -2 z: -2 }"
                  "        travel_max_mm { x: 172 y: 172 z: 172 } }"),
        bus_(test::PrivateBusOptions(kCell)),
        interlocks_(bus_, bus::kInterlock, kCell) {}

  void SetUp() override {
    ASSERT_TRUE(engraver_.AwaitReady()) << engraver_.program().Output();
  }
  std::unique_ptr<Running> Start(const std::string& log,
                                 const std::vector<std::string>& more = {}) {
    std::vector<std::string> arguments = {
        "--machine",  machine_file_.string(), "--device", engraver_.laser_line(),
        "--tag",      test::PrivateTag(),     "--cell",   kCell,
        "--real-time"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return std::make_unique<Running>(intaglio::testing::Program("intaglio-synchronizer"),
                                     arguments, folder_ / log);
  }
  bool LineIsUp() {
    bool up = false;
    return Eventually([&] {
      interlocks_.Take([&](const intaglio_Interlock& s) { up = s.laser_link_up; });
      return up;
    });
  }

  std::filesystem::path folder_;
  std::filesystem::path machine_file_ =
      INTAGLIO_SOURCE_DIR "/deploy/machines/els-03.textproto";
  virtual_engraver::EngraverProcess engraver_;
  bus::Bus bus_;
  bus::Reader<intaglio_Interlock> interlocks_;
};

TEST_F(SynchronizerProcess, OfAnUnknownLaserEndsAtOnceAndNamesWhatThereIs) {
  auto machine = ReadMachineFile(machine_file_).value();
  machine.mutable_laser_line()->set_protocol("grbl");
  machine_file_ = folder_ / "grbl.textproto";
  ASSERT_TRUE(WriteMachineFile(machine_file_, machine));
  const auto ended = Start("synchronizer.log")->WaitForEnd(5s);
  EXPECT_EQ(ended.exit_code, 2);
  EXPECT_THAT(ended.output,
              AllOf(HasSubstr(machine_file_.string()),
                    HasSubstr("laser_line.protocol: no driver for 'grbl'; there are: "
                              "virtual-laser")));
}

TEST_F(SynchronizerProcess, WhoseLaserIsTakenOverEndsWithAFault) {
  const auto synchronizer = Start("synchronizer.log");
  ASSERT_TRUE(LineIsUp()) << synchronizer->Output();
  ASSERT_TRUE(virtual_engraver::TakeLineOver(engraver_.laser_line()));
  const auto ended = synchronizer->WaitForEnd(5s);
  EXPECT_EQ(ended.exit_code, 4);
  EXPECT_NE(ended.output.find(
                "another synchronizer has taken over this machine; this process ends"),
            std::string::npos)
      << ended.output;
}

/// A job of twenty points whose path and empty journal lie in its folder already, and the
/// statuses published for it.
class WithAJob : public SynchronizerProcess {
 protected:
  static constexpr std::uint64_t kEpoch = 2000;

  WithAJob()
      : tasks_(bus_, bus::kEngraveTask),
        permissions_(bus_, bus::kPermission, kCell),
        stops_(bus_, bus::kEmergencyStop, kCell),
        commands_(bus_, bus::kJobCommand),
        health_(bus_, bus::kServiceHealth),
        statuses_(bus_, bus::kTaskStatus),
        lamp_(bus_, bus::kLampSync, kCell) {}

  void SetUp() override {
    SynchronizerProcess::SetUp();
    PointCloud path;
    for (int i = 0; i < 20; ++i) path.Add(Vec3(5 + 0.5 * i, 5, 5), 0);
    Leave(path);
  }
  /// In the job's folder, with an empty journal.
  void Leave(const PointCloud& path) {
    formats::PointTable table;
    table.points_mm = path.points_mm;
    table.columns = {{"source", path.source}};
    ASSERT_TRUE(formats::WritePly(folder_ / kPathFile, table));
    std::filesystem::remove(folder_ / kJournalFile);
    ASSERT_TRUE(JournalWriter::Create(
        folder_ / kJournalFile, {path.size(), kEpoch, formats::PathCrc(path.points_mm)}));
  }
  /// On the machine of the profile, in N-BK7.
  FrozenJob Job() {
    FrozenJob job =
        test::CellJobOf(kJob, ReadMachineFile(machine_file_).value(), Vec3(50, 50, 30));
    job.set_epoch(kEpoch);
    job.set_result_directory(folder_.string());
    return job;
  }
  void StartBridge() {
    bridge_ = std::make_unique<Running>(
        intaglio::testing::Program("intaglio-motion-bridge"),
        std::vector<std::string>{"--machine",
                                 INTAGLIO_SOURCE_DIR "/deploy/machines/els-03.textproto",
                                 "--device", engraver_.motion_line(), "--tag",
                                 test::PrivateTag(), "--cell", kCell, "--real-time"},
        folder_ / "bridge.log");
  }
  /// To the synchronizer of this process id, when it is ready.
  bool Give(pid_t worker) { return Give(worker, Job()); }
  bool Give(pid_t worker, const FrozenJob& job) {
    return Hand(worker, job) && IsPrepared();
  }
  bool Hand(pid_t worker, const FrozenJob& job) {
    total_count_ = 0;
    state_ = intaglio_TASK_ACCEPTED;
    std::string instance;
    const bool ready = Eventually([&] {
      health_.Take([&](const intaglio_ServiceHealth& s) {
        if (s.pid == worker && s.state == intaglio_HEALTH_READY)
          instance = bus::View(s.instance);
      });
      return !instance.empty();
    });
    const std::string text = job.SerializeAsString();
    const std::vector<std::uint8_t> bytes(text.begin(), text.end());
    intaglio_StageTask task{};
    task.job_uid = bus::Borrow(kJob);
    task.attempt = 1;
    task.stage = intaglio_STAGE_ENGRAVE;
    task.worker = bus::Borrow(instance);
    task.take_up = true;
    bus::Borrow(task.frozen_job, bytes);
    return ready && tasks_.Write(task).has_value();
  }
  /// The journal names no power-up of the laser, so it is not known what happened since
  /// an arm that is published by then. As the job service does, this publishes one that
  /// is withdrawn.
  bool IsPrepared() {
    return Eventually([&] {
      Permit(kEpoch, 0, false);
      TakeStatuses();
      return total_count_ > 0 || state_ == intaglio_TASK_FAILED;
    });
  }
  /// Numbered from the first arm by a person on, which is 1.
  void Permit(std::uint64_t epoch, std::uint64_t grant, bool granted = true) {
    const std::string who = "ann";
    intaglio_Permission sample{};
    sample.cell = bus::Borrow(kCell);
    sample.job_uid = bus::Borrow(kJob);
    sample.epoch = epoch;
    sample.granted = granted;
    sample.operator_name = bus::Borrow(who);
    sample.number = ++permission_number_;
    sample.speed_percent = 100;
    sample.grant = grant + 1;
    EXPECT_TRUE(permissions_.Write(sample));
  }
  static void Press(bus::Writer<intaglio_EmergencyStop>& stops, std::uint64_t number) {
    WriteStop(stops, "presser", true, number, {});
  }
  /// Releases that press and the earlier ones.
  void Reset(std::uint64_t pressed_number) {
    WriteStop(stops_, "resetter", false, ++reset_number_, {{"presser", pressed_number}});
  }
  static void WriteStop(bus::Writer<intaglio_EmergencyStop>& stops,
                        const std::string& source, bool pressed, std::uint64_t number,
                        const std::vector<host::StopPress>& released) {
    const auto wire = host::WireOf(released);
    intaglio_EmergencyStop sample{};
    sample.cell = bus::Borrow(kCell);
    sample.source = sample.operator_name = sample.reason = bus::Borrow(source);
    sample.number = number;
    sample.pressed = pressed;
    bus::Borrow(sample.released, wire);
    EXPECT_TRUE(stops.Write(sample));
  }
  /// The synchronizer reports these presses and no other.
  bool Reports(const std::vector<host::StopPress>& presses) {
    std::optional<std::vector<host::StopPress>> held;
    return Eventually([&] {
      interlocks_.Take([&](const intaglio_Interlock& sample) {
        held.emplace();
        for (const intaglio_StopPress& press : bus::View(sample.bus_stops))
          held->push_back({press.source, press.number});
      });
      return held == presses;
    });
  }
  bool Holds(std::uint64_t number) { return Reports({{"presser", number}}); }
  /// What is armed before is spent.
  bool IsReleased() { return Reports({}); }
  void SendArm(std::uint64_t epoch) {
    const std::string who = "ann";
    intaglio_JobCommand sample{};
    sample.sender = bus::Borrow(who);
    sample.job_uid = bus::Borrow(kJob);
    sample.epoch = epoch;
    sample.number = 77;
    sample.kind = intaglio_COMMAND_ARM;
    sample.operator_name = bus::Borrow(who);
    EXPECT_TRUE(commands_.Write(sample));
  }
  /// Pulses within the time, the permission being published every 20 ms.
  bool FiresWithin(std::chrono::milliseconds time, std::uint64_t epoch,
                   std::uint64_t grant) {
    const auto end = std::chrono::steady_clock::now() + time;
    while (std::chrono::steady_clock::now() < end) {
      Permit(epoch, grant);
      std::this_thread::sleep_for(20ms);
      if (permission_number_ % 10 == 0 && engraver_.StatusOf("pulses") != "0")
        return true;
    }
    return engraver_.StatusOf("pulses") != "0";
  }

  std::string StagePlace() const {
    const std::string status = engraver_.Ask("status");
    std::smatch place;
    std::regex_search(status, place, std::regex("\"stage_mm\": (\\[[^\\]]*\\])"));
    return place[1];
  }
  void TakeStatuses() {
    statuses_.Take([this](const intaglio_TaskStatus& s) {
      state_ = s.state;
      error_code_ = s.error_code;
      message_ = bus::View(s.message);
      estimate_ticks_ = std::max(estimate_ticks_, s.estimate_ticks);
      total_count_ = s.total_count;
    });
  }

  const std::string kJob = "job-of-an-earlier-day";
  bus::Writer<intaglio_StageTask> tasks_;
  bus::Writer<intaglio_Permission> permissions_;
  bus::Writer<intaglio_EmergencyStop> stops_;
  bus::Writer<intaglio_JobCommand> commands_;
  bus::Reader<intaglio_ServiceHealth> health_;
  bus::Reader<intaglio_TaskStatus> statuses_;
  bus::Reader<intaglio_LampSync> lamp_;
  intaglio_TaskState state_ = intaglio_TASK_ACCEPTED;  // and so on, by the newest status
  intaglio_ErrorCode error_code_ = intaglio_ERROR_NONE;
  std::string message_;
  std::uint64_t estimate_ticks_ = 0, total_count_ = 0;
  std::unique_ptr<Running> bridge_;
  std::uint64_t permission_number_ = 0, reset_number_ = 0;
};

// All of it is retained, so a service that starts receives it at once.
TEST_F(WithAJob, WhatWasReportedInAnEarlierRunFiresNothing) {
  Permit(kEpoch - 1, 1u << 20);
  Reset(std::numeric_limits<std::uint64_t>::max());
  SendArm(kEpoch - 1);
  StartBridge();
  const auto synchronizer = Start("synchronizer.log");
  ASSERT_TRUE(LineIsUp()) << synchronizer->Output();
  ASSERT_TRUE(Give(synchronizer->pid()));
  EXPECT_FALSE(FiresWithin(2s, kEpoch - 1, 1u << 20)) << "kept fresh all the time";
  // The same with its own epoch does.
  EXPECT_TRUE(FiresWithin(15s, kEpoch, 1)) << synchronizer->Output();
}

TEST_F(WithAJob, AStopPressedBeforeItStartedHoldsUntilItIsResetAndArmedAnew) {
  Press(stops_, 7);
  StartBridge();
  const auto synchronizer = Start("synchronizer.log");
  ASSERT_TRUE(LineIsUp()) << synchronizer->Output();
  ASSERT_TRUE(Give(synchronizer->pid()));
  EXPECT_FALSE(FiresWithin(1s, kEpoch, 1));
  Reset(6);  // of an earlier press
  EXPECT_FALSE(FiresWithin(500ms, kEpoch, 2));
  Reset(7);
  EXPECT_FALSE(FiresWithin(1s, kEpoch, 2)) << "armed while it was pressed";
  EXPECT_TRUE(FiresWithin(15s, kEpoch, 3)) << synchronizer->Output();
}

// It shows that there was a press: what was armed before is not fired.
TEST_F(WithAJob, AResetThatArrivesBeforeItsPressStopsOnceAllTheSame) {
  StartBridge();
  const auto synchronizer = Start("synchronizer.log");
  ASSERT_TRUE(LineIsUp()) << synchronizer->Output();
  ASSERT_TRUE(Give(synchronizer->pid()));
  ASSERT_FALSE(FiresWithin(300ms, kEpoch, 1)) << "the lamp is not warm yet";
  Reset(7);
  Press(stops_, 7);
  EXPECT_FALSE(FiresWithin(4s, kEpoch, 1));
  EXPECT_TRUE(FiresWithin(15s, kEpoch, 2)) << synchronizer->Output();
}

// The presser has ended, so no process sends its press to the new synchronizer: the
// motion bridge reports that it holds it. Else no reset could name it.
TEST_F(WithAJob, AStopSurvivesItsPresserAndTheSynchronizer) {
  StartBridge();
  auto synchronizer = Start("synchronizer.log");
  ASSERT_TRUE(LineIsUp()) << synchronizer->Output();
  {
    bus::Reader<intaglio_MotionState> states(bus_, bus::kMotionState, kCell);
    bus::Writer<intaglio_EmergencyStop> stops(bus_, bus::kEmergencyStop, kCell);
    Press(stops, 7);
    EXPECT_TRUE(Eventually([&] {
      bool held = false;
      states.Take([&](const intaglio_MotionState& sample) {
        held = sample.bus_stops._length == 1;
      });
      return held;
    })) << "by the bridge";
  }
  EXPECT_TRUE(Holds(7));
  synchronizer.reset();  // killed
  EXPECT_TRUE(Eventually([&] {
    bool gone = false;
    interlocks_.TakeAll([&](const intaglio_Interlock&, const bus::SampleOrigin& origin) {
      gone = gone || !origin.alive;
    });
    return gone;
  })) << "what it reported is read";
  synchronizer = Start("next.log");
  EXPECT_TRUE(Holds(7)) << synchronizer->Output();
  ASSERT_TRUE(Give(synchronizer->pid()));
  EXPECT_FALSE(FiresWithin(1s, kEpoch, 1));
  Reset(7);
  EXPECT_TRUE(IsReleased()) << synchronizer->Output();
  EXPECT_TRUE(FiresWithin(15s, kEpoch, 2)) << synchronizer->Output();
}

// What a file of the submitter contains about the machine has no effect on motion.
TEST_F(WithAJob, AJobForAnotherMachineIsRefusedAndEnds) {
  StartBridge();
  const auto synchronizer = Start("synchronizer.log");
  ASSERT_TRUE(LineIsUp()) << synchronizer->Output();
  const std::string before = StagePlace();
  ASSERT_NE(before, "");
  FrozenJob job = Job();
  job.mutable_machine()->mutable_x()->set_travel_max_mm(400);
  job.mutable_machine()->mutable_block_origin_mm()->set_y(-20);
  ASSERT_TRUE(Give(synchronizer->pid(), job));
  EXPECT_FALSE(FiresWithin(1s, kEpoch, 1));
  TakeStatuses();
  EXPECT_EQ(state_, intaglio_TASK_FAILED);
  EXPECT_EQ(error_code_, intaglio_ERROR_REFUSED);
  EXPECT_THAT(message_,
              AllOf(HasSubstr("x.travel_max_mm is 400 in the job's profile and 172"),
                    HasSubstr("block_origin_mm.y"), HasSubstr(machine_file_.string())));
  EXPECT_EQ(StagePlace(), before);
  // Refused is the job, not the machine.
  ASSERT_TRUE(Give(synchronizer->pid()));
  EXPECT_TRUE(FiresWithin(15s, kEpoch, 2)) << synchronizer->Output();
}

TEST_F(WithAJob, APathOutOfTheBlockIsRefusedAndEnds) {
  PointCloud path;
  for (int i = 0; i < 20; ++i) path.Add(Vec3(5 + 3.0 * i, 5, 5), 0);
  Leave(path);
  StartBridge();
  const auto synchronizer = Start("synchronizer.log");
  ASSERT_TRUE(LineIsUp()) << synchronizer->Output();
  ASSERT_TRUE(Give(synchronizer->pid()));
  EXPECT_FALSE(FiresWithin(1s, kEpoch, 1));
  TakeStatuses();
  EXPECT_EQ(state_, intaglio_TASK_FAILED);
  EXPECT_THAT(message_, AllOf(HasSubstr("4 of 20 points"),
                              HasSubstr("point 16 of the order"), HasSubstr("x 53")));
}

/// A machine whose profile names two outputs and two inputs for other uses.
class WithAccessories : public WithAJob {
 protected:
  void SetUp() override {
    auto machine = ReadMachineFile(machine_file_).value();
    MachineOutput& extraction = *machine.add_outputs();
    extraction.set_name("extraction");
    extraction.set_output(1);
    MachineOutput& air = *machine.add_outputs();
    air.set_name("air");
    air.set_output(3);
    air.set_on(OUTPUT_WHILE_ENGRAVING);
    MachineInput& clamp = *machine.add_inputs();
    clamp.set_name("clamp");
    clamp.set_input(1);
    clamp.set_remedy("close the clamp");
    MachineInput& filter = *machine.add_inputs();
    filter.set_name("filter full");
    filter.set_input(2);
    filter.set_state(INPUT_OFF);
    filter.set_remedy("change the filter");
    machine_file_ = folder_ / "els-03.textproto";
    ASSERT_TRUE(WriteMachineFile(machine_file_, machine));
    WithAJob::SetUp();
    StartBridge();
    synchronizer_ = Start("synchronizer.log");
    ASSERT_TRUE(LineIsUp()) << synchronizer_->Output();
    ASSERT_TRUE(Give(synchronizer_->pid())) << synchronizer_->Output();
  }
  std::string Outputs() const { return engraver_.StatusOf("outputs"); }
  /// The permission being published every 20 ms.
  bool Reach(std::uint64_t grant, const std::function<bool()>& condition) {
    const auto end = std::chrono::steady_clock::now() + 15s;
    while (std::chrono::steady_clock::now() < end) {
      Permit(kEpoch, grant);
      if (condition()) return true;
      std::this_thread::sleep_for(20ms);
    }
    return false;
  }
  /// What the newest Interlock has of them.
  void TakeInterlocks() {
    interlocks_.Take([this](const intaglio_Interlock& sample) {
      open_input_ = bus::View(sample.open_input);
      outputs_on_ = bus::View(sample.outputs_on);
    });
  }

  std::unique_ptr<Running> synchronizer_;
  std::string open_input_, outputs_on_;
};

TEST_F(WithAccessories, OutputsAreOnWhileTheArmHolds) {
  EXPECT_EQ(Outputs(), "0") << "nobody has armed";
  ASSERT_TRUE(Reach(1, [&] { return Outputs() == "1"; })) << synchronizer_->Output();
  TakeInterlocks();
  Permit(kEpoch, 1, false);
  EXPECT_TRUE(Eventually([&] { return Outputs() == "0"; })) << "the arm was withdrawn";
  ASSERT_TRUE(Reach(2, [&] { return Outputs() == "1"; }));
  EXPECT_TRUE(Eventually([&] { return Outputs() == "0"; })) << "it is not repeated";
  EXPECT_TRUE(Reach(3, [&] { return Outputs() == "5"; })) << "a run is made";
  TakeInterlocks();
  EXPECT_EQ(open_input_, "");
  EXPECT_TRUE(Reach(3, [&] {
    return engraver_.StatusOf("pulses") == "20" && Outputs() == "0";
  })) << "the job has ended";
}

TEST_F(WithAccessories, OutputsGoOffWhenTheSynchronizerIsKilled) {
  ASSERT_TRUE(Reach(1, [&] { return Outputs() == "1"; })) << synchronizer_->Output();
  Permit(kEpoch, 1);
  synchronizer_->Signal(SIGSTOP);
  std::this_thread::sleep_for(150ms);
  EXPECT_EQ(Outputs(), "1") << "within the time of the line";
  EXPECT_TRUE(Eventually([&] { return Outputs() == "0"; })) << "it hangs";
  EXPECT_EQ(engraver_.StatusOf("safe_state"), "true");
  synchronizer_->Signal(SIGCONT);
  ASSERT_TRUE(Reach(2, [&] { return Outputs() == "1"; })) << synchronizer_->Output();
  synchronizer_->Signal(SIGKILL);
  const auto killed = std::chrono::steady_clock::now();
  EXPECT_TRUE(Eventually([&] { return Outputs() == "0"; }));
  EXPECT_LT(std::chrono::steady_clock::now() - killed, 1s);
}

TEST_F(WithAccessories, AnInputThatDropsCostsTheArmByItsName) {
  ASSERT_TRUE(Reach(1, [&] { return Outputs() == "1"; })) << synchronizer_->Output();
  ASSERT_EQ(engraver_.Ask("input 1 off"), "ok");
  const std::string open = "the input 'clamp' is off: close the clamp";
  EXPECT_TRUE(Reach(1, [&] {
    TakeStatuses();
    TakeInterlocks();
    return message_ == open + ", then resume" && open_input_ == open;
  })) << message_;
  EXPECT_EQ(state_, intaglio_TASK_PAUSED);
  EXPECT_EQ(Outputs(), "0");
  ASSERT_EQ(engraver_.Ask("input 1 on"), "ok");
  EXPECT_FALSE(FiresWithin(2s, kEpoch, 1)) << "no person has armed anew";
  EXPECT_EQ(Outputs(), "0");
  EXPECT_TRUE(FiresWithin(15s, kEpoch, 2)) << synchronizer_->Output();
}

TEST_F(WithAccessories, AnInputThatIsWrongRefusesTheArm) {
  ASSERT_EQ(engraver_.Ask("input 2 on"), "ok");
  EXPECT_FALSE(FiresWithin(2s, kEpoch, 1));
  TakeStatuses();
  EXPECT_EQ(message_, "the input 'filter full' is on: change the filter, then resume");
  EXPECT_EQ(Outputs(), "0");
  ASSERT_EQ(engraver_.Ask("input 2 off"), "ok");
  EXPECT_FALSE(FiresWithin(1s, kEpoch, 1));
  EXPECT_TRUE(FiresWithin(15s, kEpoch, 2)) << synchronizer_->Output();
}

struct WrongMount {
  std::vector<std::string> options;
  const char* message;
};

class MountedOtherwise : public WithAJob,
                         public ::testing::WithParamInterface<WrongMount> {};

TEST_P(MountedOtherwise, IsNotFiredAndReportsWhatIsMountedAndWanted) {
  StartBridge();
  const auto synchronizer = Start("synchronizer.log", GetParam().options);
  ASSERT_TRUE(LineIsUp()) << synchronizer->Output();
  ASSERT_TRUE(Give(synchronizer->pid()));
  EXPECT_FALSE(FiresWithin(3s, kEpoch, 1));
  TakeStatuses();
  EXPECT_EQ(state_, intaglio_TASK_PAUSED) << message_;
  EXPECT_THAT(message_, HasSubstr(GetParam().message));
}

INSTANTIATE_TEST_SUITE_P(
    LensGlassAndBlock, MountedOtherwise,
    ::testing::Values(WrongMount{{"--lens", "f70"},
                                 "the lens f70 (f 70 mm, NA 0.0357) is mounted"},
                      WrongMount{{"--block-index", "1.46"}, "has the index 1.46"},
                      WrongMount{{"--block", "50,50,40"}, "50 x 50 x 40 mm"}));

TEST_F(WithAJob, IsFiredWhereItsOwnLensGlassAndBlockAreMounted) {
  StartBridge();
  const auto synchronizer = Start("synchronizer.log", {"--lens", "f43", "--block-index",
                                                       "1.5197", "--block", "60,50,30"});
  ASSERT_TRUE(LineIsUp()) << synchronizer->Output();
  ASSERT_TRUE(Give(synchronizer->pid()));
  EXPECT_TRUE(FiresWithin(15s, kEpoch, 1)) << synchronizer->Output();
}

TEST_F(SynchronizerProcess, ALensThatTheMachineDoesNotHaveIsWrongInput) {
  const auto synchronizer = Start("synchronizer.log", {"--lens", "f50"});
  const auto ended = synchronizer->WaitForEnd(5s);
  EXPECT_EQ(ended.exit_code, 2);
  EXPECT_THAT(ended.output, AllOf(HasSubstr("--lens"), HasSubstr("f43, f70")));
}

// Its whole plan takes seconds. Meanwhile the loop turns, and the first points are fired.
TEST_F(WithAJob, AMillionPointsAreFiredBeforeTheWholeIsPlanned) {
  std::stringstream profile;
  profile << std::ifstream(machine_file_).rdbuf();
  machine_file_ = folder_ / "els-03.textproto";
  std::ofstream(machine_file_) << std::regex_replace(
      profile.str(), std::regex("max_acceleration_mm_s2: 7000"),
      "max_acceleration_mm_s2: 7000 max_jerk_mm_s3: 1000000");
  PointCloud path;
  for (int i = 0; i < 1'000'000; ++i) {
    const int row = i / 100, along = row % 2 == 0 ? i % 100 : 99 - i % 100;
    path.Add(Vec3(5 + 0.4 * along, 5 + 0.004 * row, 5), 0);
  }
  Leave(path);
  StartBridge();
  const auto synchronizer = Start("synchronizer.log");
  ASSERT_TRUE(LineIsUp()) << synchronizer->Output();
  ASSERT_TRUE(Hand(synchronizer->pid(), Job()));
  const auto began = std::chrono::steady_clock::now();
  auto turned = began;
  std::chrono::nanoseconds longest_gap{0};
  bool fires = false;
  for (auto now = began; !fires && now - began < 60s;
       now = std::chrono::steady_clock::now()) {
    if (lamp_.Take([](const intaglio_LampSync&) {}) > 0) turned = now;
    longest_gap = std::max<std::chrono::nanoseconds>(longest_gap, now - turned);
    TakeStatuses();
    if (total_count_ == 0) {
      Permit(kEpoch, 0, false);
      std::this_thread::sleep_for(20ms);
    } else {
      fires = FiresWithin(20ms, kEpoch, 1);
    }
  }
  EXPECT_TRUE(fires) << synchronizer->Output();
  EXPECT_EQ(estimate_ticks_, 0) << "planned to its end before the first pulse";
  EXPECT_LT(longest_gap, 1500ms);
  std::cout << "first pulse after " << (std::chrono::steady_clock::now() - began) / 1ms
            << " ms, longest time without a status of the lamp " << longest_gap / 1ms
            << " ms\n";
}

}  // namespace
}  // namespace intaglio::synchronizer
