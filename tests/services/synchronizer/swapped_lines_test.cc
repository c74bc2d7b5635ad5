// Two cells on one computer, each a synchronizer and a motion bridge as processes and a
// virtual engraver with serial numbers of its own, and their cables in right or wrong.

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <set>
#include <thread>

#include "engrave/formats/point_file.h"
#include "services/cell/journal_writer.h"
#include "services/job/files/job_file.h"
#include "services/platform/bus/bus.h"
#include "services/platform/bus/samples.h"
#include "services/synchronizer/job_folder.h"
#include "services/synchronizer/pulses/cell_names.h"
#include "tests/patience.h"
#include "tests/services/platform/bus/private_bus.h"
#include "tests/services/platform/host/stage/stage_shop.h"
#include "tests/services/virtual_engraver/engraver_process.h"
#include "tests/test_folder.h"

namespace intaglio::synchronizer {
namespace {

namespace fs = std::filesystem;
using intaglio::testing::Running;
using test::Eventually;
using ::testing::Contains;
using ::testing::HasSubstr;
using virtual_engraver::EngraverProcess;
using namespace std::chrono_literals;

constexpr std::uint64_t kEpoch = 2000;
constexpr int kPoints = 500;  // five seconds and more

bus::BusOptions BusOf(const std::string& cell) { return test::PrivateBusOptions(cell); }

/// One machine with its services, and a job of a few points that lies in its folder.
class Cell {
 public:
  Cell(const fs::path& folder, const std::string& name)
      : name_(name),
        folder_(folder / name),
        bus_((fs::create_directories(folder_), BusOf(name))),
        tasks_(bus_, bus::kEngraveTask),
        permissions_(bus_, bus::kPermission, name),
        health_(bus_, bus::kServiceHealth),
        alarms_(bus_, bus::kAlarm),
        reports_(bus_, bus::kTaskStatus),
        states_(bus_, bus::kMotionState, name),
        interlocks_(bus_, bus::kInterlock, name),
        engraver_(folder_,
                  "laser { rates_hz: [100, 200] door_lock: true serial_number: '" +
                      Laser() +
                      "' } stage { travel_min_mm { x: -2 y: -2 z: -2 }"
                      " travel_max_mm { x: 172 y: 172 z: 172 }"
                      " position_tolerance_um: 30 serial_number: '" +
                      Stage() + "' }") {}

  std::string Laser() const { return "laser of " + name_; }
  std::string Stage() const { return "stage of " + name_; }
  const EngraverProcess& engraver() const { return engraver_; }
  bool AwaitMachine() { return engraver_.AwaitReady(); }

  /// The cables, as they are plugged in: symbolic links beside the profile.
  fs::path LaserPort() const { return folder_ / "ttyLaser"; }
  fs::path StagePort() const { return folder_ / "ttyStage"; }
  static void Plug(const fs::path& port, const std::string& line) {
    fs::remove(port);
    fs::create_symlink(line, port);
  }
  void Plug(const std::string& line, const Cell& cell) {
    line == "laser" ? PlugLaser(cell) : PlugStage(cell);
  }
  void PlugLaser(const Cell& cell) { Plug(LaserPort(), cell.engraver_.laser_line()); }
  void PlugStage(const Cell& cell) { Plug(StagePort(), cell.engraver_.motion_line()); }

  void Start() {
    machine_ =
        ReadMachineFile(INTAGLIO_SOURCE_DIR "/deploy/machines/els-03.textproto").value();
    machine_.set_name(name_);
    machine_.mutable_laser_line()->set_device(LaserPort());
    machine_.mutable_laser_line()->set_serial_number(Laser());
    machine_.mutable_motion_line()->set_device(StagePort());
    machine_.mutable_motion_line()->set_serial_number(Stage());
    ASSERT_TRUE(WriteMachineFile(folder_ / "machine.textproto", machine_));
    WriteJob();
    StartSynchronizer();
    StartBridge();
  }
  void StartSynchronizer() {
    synchronizer_ =
        Program("intaglio-synchronizer", fmt::format("sync{}.log", ++starts_));
  }
  void StartBridge() {
    bridge_ = Program("intaglio-motion-bridge", fmt::format("bridge{}.log", ++starts_));
  }
  Running& bridge() { return *bridge_; }
  Running& synchronizer() { return *synchronizer_; }

  bool Give() {
    std::string instance;
    const bool ready = Eventually([&] {
      health_.Take([&](const intaglio_ServiceHealth& s) {
        if (s.pid == synchronizer_->pid() && s.state == intaglio_HEALTH_READY)
          instance = bus::View(s.instance);
      });
      return !instance.empty();
    });
    FrozenJob job = test::CellJobOf(job_, machine_, Vec3(60, 50, 30));
    job.set_epoch(kEpoch);
    job.set_result_directory(folder_.string());
    const std::string text = job.SerializeAsString();
    const std::vector<std::uint8_t> bytes(text.begin(), text.end());
    intaglio_StageTask task{};
    task.job_uid = bus::Borrow(job_);
    task.attempt = ++attempt_;
    task.stage = intaglio_STAGE_ENGRAVE;
    task.worker = bus::Borrow(instance);
    task.take_up = true;
    bus::Borrow(task.frozen_job, bytes);
    return ready && tasks_.Write(task).has_value();
  }
  /// A person arms the job: a greater number than any before.
  void Arm() {
    ++grant_;
    armed_ = true;
    armed_at_ = std::chrono::steady_clock::now();
  }
  bool armed() const { return armed_; }
  /// The permission as the job service repeats it.
  void Permit() {
    const std::string who = "ann";
    intaglio_Permission sample{};
    sample.cell = bus::Borrow(name_);
    sample.job_uid = bus::Borrow(job_);
    sample.epoch = kEpoch;
    sample.granted = armed_;
    sample.operator_name = bus::Borrow(who);
    sample.number = ++permission_number_;
    sample.speed_percent = 100;
    sample.grant = grant_;
    sample.renewal = renewal_;
    EXPECT_TRUE(permissions_.Write(sample));
  }
  void Listen() {
    alarms_.Take(
        [&](const intaglio_Alarm& s) { alarm_texts.emplace(bus::View(s.message)); });
    reports_.Take([&](const intaglio_TaskStatus& s) {
      if (bus::View(s.job_uid) != job_) return;
      job_message = bus::View(s.message);
      if (s.state == intaglio_TASK_PAUSED) TakePause(s.pause_reason);
    });
    states_.Take([&](const intaglio_MotionState& s) {
      motion_fault = s.fault;
      motion_message = bus::View(s.message);
    });
    interlocks_.Take([&](const intaglio_Interlock& s) {
      laser_up = s.laser_link_up;
      laser_message = bus::View(s.message);
    });
  }
  std::uint64_t Pulses() const {
    const std::string text = engraver_.StatusOf("pulses");
    return text.empty() ? 0 : std::stoull(text);
  }
  std::string Logs() const { return synchronizer_->Output() + bridge_->Output(); }

  std::set<std::string> alarm_texts;
  std::string job_message, laser_message, motion_message;
  intaglio_MotionFault motion_fault = intaglio_MOTION_LINK_LOST;
  bool laser_up = false;

 private:
  /// As the job service: a lost line renews the arm, every other fault ends it. What
  /// comes soon after an arm is still about the one before.
  void TakePause(intaglio_PauseReason reason) {
    if (reason == intaglio_PAUSE_NOT_ARMED) return;
    if (std::chrono::steady_clock::now() - armed_at_ < 300ms) return;
    if (reason == intaglio_PAUSE_LINE_LOST) {
      ++renewal_;
    } else {
      armed_ = false;
    }
  }
  std::unique_ptr<Running> Program(const std::string& program, const std::string& log) {
    return std::make_unique<Running>(
        intaglio::testing::Program(program),
        std::vector<std::string>{"--machine", folder_ / "machine.textproto", "--tag",
                                 test::PrivateTag(), "--cell", name_},
        folder_ / log);
  }
  void WriteJob() const {
    formats::PointTable path;
    PointCloud cloud;
    for (int i = 0; i < kPoints; ++i) {
      path.points_mm.push_back(Vec3(5 + 0.1 * i, 5, 5));
      cloud.Add(path.points_mm.back(), 0);
    }
    path.columns = {{"source", std::vector<std::uint32_t>(kPoints, 0)}};
    ASSERT_TRUE(formats::WritePly(folder_ / kPathFile, path));
    ASSERT_TRUE(JournalWriter::Create(
        folder_ / kJournalFile, {kPoints, kEpoch, formats::PathCrc(cloud.points_mm)}));
  }

  std::string name_, job_ = "job of " + name_;
  fs::path folder_;
  bus::Bus bus_;
  bus::Writer<intaglio_StageTask> tasks_;
  bus::Writer<intaglio_Permission> permissions_;
  bus::Reader<intaglio_ServiceHealth> health_;
  bus::Reader<intaglio_Alarm> alarms_;
  bus::Reader<intaglio_TaskStatus> reports_;
  bus::Reader<intaglio_MotionState> states_;
  bus::Reader<intaglio_Interlock> interlocks_;
  EngraverProcess engraver_;
  MachineSpec machine_;
  std::unique_ptr<Running> synchronizer_, bridge_;
  int starts_ = 0;
  std::uint32_t attempt_ = 0;
  bool armed_ = false;
  std::chrono::steady_clock::time_point armed_at_;
  std::uint64_t permission_number_ = 0, grant_ = 1, renewal_ = 0;
};

std::string Refusal(const fs::path& port, const std::string& kind,
                    const std::string& answers, const std::string& cell,
                    const std::string& expected, const std::string& line) {
  return fmt::format(
      "the line at {} leads to {} '{}', the profile of {} expects '{}': swap the cables "
      "or correct {}.serial_number",
      port.string(), kind, answers, cell, expected, line);
}

class TwoCells : public ::testing::Test {
 protected:
  void SetUp() override {
    ASSERT_TRUE(a_.AwaitMachine());
    ASSERT_TRUE(b_.AwaitMachine());
    a_.PlugLaser(a_), a_.PlugStage(a_);
    b_.PlugLaser(b_), b_.PlugStage(b_);
  }
  void StartBoth() {
    a_.Start();
    b_.Start();
    ASSERT_TRUE(a_.Give()) << a_.Logs();
    ASSERT_TRUE(b_.Give()) << b_.Logs();
    // What was armed before the job was given is not trusted.
    TurnFor(300ms);
    ArmBoth();
  }
  void ArmBoth() { a_.Arm(), b_.Arm(); }
  /// The permissions are repeated until the condition holds; false when the time is up
  /// first.
  bool Until(std::chrono::milliseconds bound, const std::function<bool()>& condition) {
    const test::Patience patience(bound);
    for (int turn = 0; !patience.over(); ++turn) {
      a_.Permit(), b_.Permit();
      a_.Listen(), b_.Listen();
      std::this_thread::sleep_for(20ms);
      if (turn % 10 == 0 && condition()) return true;
    }
    return false;
  }
  void TurnFor(std::chrono::milliseconds time) {
    (void)Until(time, [] { return false; });
  }
  bool BothEngrave() {
    return Until(30s,
                 [this] { return a_.Pulses() == kPoints && b_.Pulses() == kPoints; });
  }
  /// Both cables at once, while everything runs.
  void Swap(const std::string& line, Cell& of_a, Cell& of_b) {
    for (const Cell* cell : {&a_, &b_}) (void)cell->engraver().Ask("unplug " + line);
    a_.Plug(line, of_a), b_.Plug(line, of_b);
    for (const Cell* cell : {&a_, &b_}) (void)cell->engraver().Ask("plug " + line);
  }
  /// A host that was at the other machine with a lower epoch is fenced off there and
  /// ends; what starts it again gives it its job again.
  void RestartWhoEnded() {
    for (Cell* cell : {&a_, &b_}) {
      if (!cell->bridge().running()) cell->StartBridge();
      if (cell->synchronizer().running()) continue;
      cell->StartSynchronizer();
      ASSERT_TRUE(cell->Give());
    }
  }
  bool AnyFires() { return a_.Pulses() + b_.Pulses() > 0; }
  std::string LaserRefusal(const Cell& at, const Cell& other,
                           const std::string& name) const {
    return Refusal(at.LaserPort(), "laser", other.Laser(), name, at.Laser(),
                   "laser_line");
  }
  std::string StageRefusal(const Cell& at, const Cell& other,
                           const std::string& name) const {
    return Refusal(at.StagePort(), "stage controller", other.Stage(), name, at.Stage(),
                   "motion_line");
  }

  fs::path folder_ = test::FreshFolder();
  Cell a_{folder_, "cell-a"}, b_{folder_, "cell-b"};
};

TEST_F(TwoCells, WithTheirOwnLinesBothEngrave) {
  StartBoth();
  EXPECT_TRUE(BothEngrave()) << a_.job_message << "\n" << b_.job_message << a_.Logs();
  EXPECT_THAT(a_.alarm_texts, ::testing::IsEmpty());
}

TEST_F(TwoCells, WithSwappedLaserLinesNothingIsLitOrFiredAndBothReportWhy) {
  a_.PlugLaser(b_), b_.PlugLaser(a_);
  StartBoth();
  EXPECT_FALSE(Until(3s, [this] { return AnyFires(); }));
  const std::string of_a = LaserRefusal(a_, b_, "cell-a"),
                    of_b = LaserRefusal(b_, a_, "cell-b");
  EXPECT_EQ(a_.job_message, of_a + ", then resume");
  EXPECT_EQ(b_.job_message, of_b + ", then resume");
  EXPECT_EQ(a_.laser_message, of_a);
  EXPECT_EQ(b_.laser_message, of_b);
  EXPECT_FALSE(a_.laser_up || b_.laser_up);
  EXPECT_THAT(a_.alarm_texts, Contains(of_a));
  EXPECT_THAT(b_.alarm_texts, Contains(of_b));
  for (const Cell* cell : {&a_, &b_}) {
    EXPECT_EQ(cell->engraver().StatusOf("shutters"), "0");
    EXPECT_EQ(std::stoi(cell->engraver().StatusOf("interlocks")) & link::kLampOn, 0);
    EXPECT_EQ(cell->engraver().StatusOf("running"), "false");
  }
}

// The person who corrects the cables is at the machines: each of them is armed anew.
class LinesSwappedInMidJob : public TwoCells,
                             public ::testing::WithParamInterface<std::string> {
 protected:
  std::string Message(const Cell& at, const Cell& other, const std::string& name) const {
    return (GetParam() == "laser" ? LaserRefusal(at, other, name)
                                  : StageRefusal(at, other, name)) +
           ", then resume";
  }
};

TEST_P(LinesSwappedInMidJob, FireNothingUntilTheyAreRightAndArmedAnew) {
  StartBoth();
  ASSERT_TRUE(Until(20s, [this] { return a_.Pulses() > 50 && b_.Pulses() > 50; }));
  Swap(GetParam(), b_, a_);
  TurnFor(1500ms);
  RestartWhoEnded();
  EXPECT_TRUE(Until(10s,
                    [this] {
                      return a_.job_message == Message(a_, b_, "cell-a") &&
                             b_.job_message == Message(b_, a_, "cell-b");
                    }))
      << a_.job_message << "\n"
      << b_.job_message;
  const std::uint64_t of_a = a_.Pulses(), of_b = b_.Pulses();
  ASSERT_LT(std::max(of_a, of_b), kPoints);
  const auto more = [&] { return a_.Pulses() > of_a || b_.Pulses() > of_b; };
  EXPECT_FALSE(Until(2s, more));
  EXPECT_FALSE(a_.armed() || b_.armed());
  Swap(GetParam(), a_, b_);
  TurnFor(1500ms);
  RestartWhoEnded();
  EXPECT_FALSE(Until(3s, more));
  ArmBoth();
  EXPECT_TRUE(BothEngrave()) << a_.job_message << "\n" << b_.job_message << a_.Logs();
  std::this_thread::sleep_for(500ms);
  EXPECT_EQ(a_.Pulses(), kPoints);
  EXPECT_EQ(b_.Pulses(), kPoints);
}

INSTANTIATE_TEST_SUITE_P(Of, LinesSwappedInMidJob, ::testing::Values("laser", "motion"),
                         [](const auto& line) { return line.param; });

TEST_F(TwoCells, WithSwappedMotionLinesNothingMovesOrFiresAndBothReportWhy) {
  a_.PlugStage(b_), b_.PlugStage(a_);
  StartBoth();
  const std::string at = a_.engraver().StatusOf("stage_mm");
  EXPECT_FALSE(Until(3s, [this] { return AnyFires(); }));
  const std::string of_a = StageRefusal(a_, b_, "cell-a"),
                    of_b = StageRefusal(b_, a_, "cell-b");
  EXPECT_EQ(a_.job_message, of_a + ", then resume");
  EXPECT_EQ(b_.job_message, of_b + ", then resume");
  for (const auto& [cell, why] : {std::pair(&a_, of_a), std::pair(&b_, of_b)}) {
    EXPECT_EQ(cell->motion_fault, intaglio_MOTION_WRONG_CONTROLLER);
    EXPECT_EQ(cell->motion_message, why);
    EXPECT_THAT(cell->alarm_texts, Contains(why));
    EXPECT_EQ(cell->engraver().StatusOf("running"), "false");
    EXPECT_EQ(cell->engraver().StatusOf("stage_mm"), at);
  }
}

}  // namespace
}  // namespace intaglio::synchronizer
