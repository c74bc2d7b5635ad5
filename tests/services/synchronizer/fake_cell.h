#pragma once

// One cell on a bench: an Engraving between a fake laser on a line in memory, a fake
// stage and a journal, on a clock that the test moves by 1 ms at a time. What the journal
// and the ledger claim is held against the fake glass.

#include <chrono>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "proto/machine.pb.h"
#include "services/synchronizer/engraving.h"
#include "tests/services/platform/link/faulty_line.h"
#include "tests/services/synchronizer/fake_laser.h"
#include "tests/services/synchronizer/fake_stage.h"

namespace intaglio::synchronizer {

struct CellOptions {
  std::uint32_t points = 40;
  bool lockstep = false;
  bool simulates_time = false;  ///< else, in lockstep, a real controller that waits
  std::vector<ChannelMask> masks = {};  ///< of the points; empty: all in channel 1
  PointEnergies energies = {{12.5}, {}};
  std::uint32_t max_missed_in_a_row = 5;
  bool photosensor_feedback = true;
  bool asks_when_uncertain = false;
  std::string block_misfit = {};
  bool needs_door_lock = false;  ///< of the profile
  MachineSpec accessories = {};  ///< its outputs and inputs; the controller has 8 of each
  std::optional<Vec2> block_stage_mm = {};   ///< where the job needs it; none: no stage
  std::string laser_serial_number = "A-03";  ///< the profile expects A-03
};

/// An order whose shutters change every few points.
std::vector<ChannelMask> MasksInStretches(std::uint32_t count);

class FakeCell {
 public:
  explicit FakeCell(const CellOptions& options = {});
  ~FakeCell();

  /// One millisecond: ticks, line, stage, one turn of the engraving.
  void Step();
  void StepFor(std::chrono::milliseconds time);
  /// False when it did not become true within `limit`.
  bool StepUntil(const std::function<bool()>& condition,
                 std::chrono::milliseconds limit = std::chrono::seconds(20));
  bool StepUntilDone() {
    return StepUntil([this] { return done(); });
  }
  bool StepUntilMade(std::uint64_t count) {
    return StepUntil([this, count] { return laser.cracks().size() >= count; });
  }

  void Grant() {
    RepeatGrant();
    ++grant.number;
    fire_uncertain = false;
  }
  /// The same one again, and as the job service renews it after a lost line.
  void RepeatGrant() {
    permission_granted = true;
    granted_at_ = now;
    renewed_at_ = kNever;
    renewals_ = 0;
  }
  void RenewGrant() {
    RepeatGrant();
    ++grant.renewal;
  }
  /// As a person's resume with the consent to fire what is uncertain.
  void GrantFiringUncertain() {
    GrantAnew();
    fire_uncertain = true;
  }
  void Withdraw() {
    permission_granted = false;
    renewed_at_ = kNever;
  }
  /// What an operator's resume is: the permission withdrawn, and given anew, at a machine
  /// whose laser answers (or is given up on).
  void GrantAnew();

  /// So many lamp syncs do not come.
  void LeaveOutSyncs(std::uint32_t count);
  void CutLine(bool cut);
  /// A second without a line, and a controller that no longer knows what it fired in it:
  /// until everything that was armed is settled, as uncertain.
  void CutLineOverForgottenPulses();
  /// As kill -9 of the synchronizer and a new one: what it knew is lost but for the
  /// journal, of which `keep` leaves what came to the disk.
  void DieAndTakeUp(
      const std::function<void(const std::filesystem::path&)>& keep = nullptr);
  /// The next life is given another block than the job's.
  void ChangeBlock(const std::string& misfit) { options_.block_misfit = misfit; }
  /// As the laser's mains switch: the line is silent for `time`, then another power-up.
  void PowerCycle(std::chrono::milliseconds time);

  Engraving::Phase phase() const { return engraving->phase(); }
  bool done() const { return phase() == Engraving::Phase::kDone; }
  std::uint64_t made() const { return Count(PointState::kMade); }
  std::uint64_t Count(PointState state) const { return engraving->ledger().count(state); }

  /// The state of everything, for a failing test.
  std::string Description() const;
  /// Waits for the journal's thread; then what is on disk.
  formats::Journal JournalOnDisk() const;
  /// Every disagreement of ledger, journal and glass in a sentence; empty when all agree.
  std::vector<std::string> Disagreements() const;

  std::chrono::nanoseconds now = std::chrono::seconds(1);
  std::uint32_t speed_percent = 100;
  std::uint32_t first_point = 0;
  bool fire_uncertain = false;
  bool permission_fresh = true, permission_granted = false, stop_pressed = false;
  Vec2 block_mm = Vec2::Zero();  ///< where the controller reports the block's stage
  bool reports_block = true;     ///< where the job needs such a stage
  bool block_drives = false;     ///< EngravingInputs::stage_approaches
  std::string block_failure = {};
  bool bridge_ended = false;  ///< the bus says so of its process
  /// As the job service does: a fault withdraws the grant, and after a lost line or
  /// process the same one is renewed, a while later, again and again. False: the test
  /// itself decides about the permission.
  bool acts_as_job_service = true;
  synchronizer::Grant grant;
  std::shared_ptr<link::FaultyPipe> to_laser, to_host;
  FakeLaser laser;
  FakeStage stage;
  MotionClock* motion_clock = nullptr;  ///< of a stage that has one
  std::function<void(std::uint64_t tick)> on_tick = [](std::uint64_t) {};  ///< behind it
  std::filesystem::path journal_file;
  std::unique_ptr<JournalWriter> journal;
  std::unique_ptr<drivers::LaserController> controller;
  std::unique_ptr<MotionFeed> feed;
  PermissionChain chain;
  std::unique_ptr<Engraving> engraving;
  PointList points_mm;
  std::vector<PulseResult> results;
  /// The journal's disk is as slow as it likes; otherwise every turn waits for it.
  bool wait_for_disk = true;
  /// A lockstep machine is able to pass so many in a millisecond.
  int lockstep_ticks_a_step = 64;

 private:
  std::unique_ptr<link::ByteStream> LineEnd(bool host);
  void Begin(JobBegun begun);
  void Poll();
  void AwaitLaser();
  void ActAsJobService();
  void LosePermission(bool is_renewed);
  EngravingInputs Inputs();
  void PassTicks();
  void CheckGlass(std::vector<std::string>& wrong) const;
  void CheckJournal(std::vector<std::string>& wrong) const;

  static constexpr std::chrono::nanoseconds kNever = std::chrono::nanoseconds::max();

  CellOptions options_;
  std::chrono::nanoseconds granted_at_{0}, renewed_at_ = kNever;
  int renewals_ = 0;  // since the grant, or since a point was made
  std::uint64_t made_at_loss_ = 0;
  std::shared_ptr<std::mt19937_64> random_ = std::make_shared<std::mt19937_64>(1);
  static constexpr std::chrono::nanoseconds kPeriod{
      static_cast<std::int64_t>(1e9 / FakeLaser::kRateHz)};
  std::chrono::nanoseconds next_tick_;
  std::chrono::nanoseconds view_at_{0};
  std::chrono::nanoseconds powered_again_at_{-1};
};

}  // namespace intaglio::synchronizer
