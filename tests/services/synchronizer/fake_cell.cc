#include "tests/services/synchronizer/fake_cell.h"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <set>
#include <thread>
#include <utility>

#include "services/drivers/laser_drivers.h"
#include "services/drivers/virtual/virtual_laser_driver.h"

namespace intaglio::synchronizer {
namespace {

using formats::JournalKind;
using formats::PointOutcome;
using std::chrono::milliseconds;
using namespace std::chrono_literals;
namespace fs = std::filesystem;

// As services/synchronizer/synchronizer.cc has it.
constexpr auto kMotionLease = 500ms;
// As services/job_service has them.
constexpr auto kHold = 300ms;
constexpr int kMaxRenewals = 20;

fs::path NewJournalFile() {
  static int number = 0;
  // In memory when there is such a place: a thousand journals cost no disk.
  const fs::path folder = fs::is_directory("/dev/shm") ? "/dev/shm" : testing::TempDir();
  return folder / fmt::format("intaglio-{}-{}.bin", getpid(), ++number);
}

// Neighbours 50..250 um apart, no two in one place: a crack belongs to one point.
PointList ManyPoints(std::uint32_t count) {
  std::mt19937_64 random(7);
  PointList points;
  for (std::uint32_t i = 0; i < count; ++i) {
    points.push_back(Vec3(0.05 * i, 0.001 * static_cast<double>(random() % 200),
                          0.001 * static_cast<double>(random() % 50)));
  }
  return points;
}

PointState StateOf(PointOutcome outcome) {
  switch (outcome) {
    case PointOutcome::kNone:
      return PointState::kPlanned;
    case PointOutcome::kMade:
      return PointState::kMade;
    case PointOutcome::kMissed:
      return PointState::kMissed;
    case PointOutcome::kSkipped:
      return PointState::kSkipped;
    case PointOutcome::kLeftOut:
      return PointState::kLeftOut;
    case PointOutcome::kUncertain:
      break;
  }
  return PointState::kUncertain;
}

}  // namespace

std::vector<ChannelMask> MasksInStretches(std::uint32_t count) {
  constexpr ChannelMask kMasks[] = {15, 1, 2, 15, 8, 3};
  std::vector<ChannelMask> masks;
  for (std::uint32_t i = 0; i < count; ++i) masks.push_back(kMasks[i / 17 % 6]);
  return masks;
}

FakeCell::FakeCell(const CellOptions& options)
    : to_laser(std::make_shared<link::FaultyPipe>()),
      to_host(std::make_shared<link::FaultyPipe>()),
      laser([this] { return now; }, options.lockstep),
      journal_file(NewJournalFile()),
      points_mm(ManyPoints(options.points)),
      options_(options),
      next_tick_(now) {
  // In lockstep it comes to rest only when ticks pass, as a real one does.
  if (options.lockstep) stage.braking_ticks = 20;
  laser.serial_number = options.laser_serial_number;
  laser.locks_door = options.needs_door_lock;
  if (options.accessories.outputs_size() + options.accessories.inputs_size() > 0)
    laser.output_count = laser.input_count = link::kMaxAccessories;
  laser.waits = options.simulates_time;
  laser.Plug(LineEnd(false));
  Begin(JobBegun::kNo);
}

// What a process that is started has: the disk, the line and the bus, and nothing else.
void FakeCell::Begin(JobBegun begun) {
  MachineSpec machine = options_.accessories;
  machine.set_name("els-03");
  machine.mutable_laser_line()->set_device("/dev/ttyUSB0");
  machine.mutable_laser_line()->set_serial_number("A-03");
  if (!options_.simulates_time)
    machine.mutable_laser_line()->set_protocol(std::string(drivers::kMotionOutput));
  controller = drivers::MakeVirtualLaserDriver(
      machine,
      [this] { return Result<std::unique_ptr<link::ByteStream>>(LineEnd(true)); },
      [this] { return now; });
  feed = std::make_unique<MotionFeed>(
      [this](const intaglio_MotionSegmentBatch& batch) {
        return stage.Receive(batch, now);
      },
      [this](const std::string& stream) { return stage.GrantOf(stream); });
  auto opened = OpenJournal(journal_file, {points_mm.size(), 1, 7}, begun);
  if (!opened) throw std::runtime_error(opened.error().message);
  journal = std::move(opened->writer);
  // A synchronizer is ready when its laser answers, and is given its jobs then.
  chain = {};
  if (begun == JobBegun::kNo) {
    AwaitLaser();
    chain.BeginJob();
  } else {
    chain.BeginJob();
    chain.TakeUp({opened->earlier.power_up, opened->earlier.openings});
  }
  EngravingJob job;
  job.uid = "job";
  job.machine_points_mm = points_mm;
  job.plan.rate_hz = FakeLaser::kRateHz;
  job.energies = options_.energies;
  job.plan.profile = motion::Profile::kMix;
  job.masks = options_.masks;
  job.max_missed_in_a_row = options_.max_missed_in_a_row;
  job.photosensor_feedback = options_.photosensor_feedback;
  job.asks_when_uncertain = options_.asks_when_uncertain;
  job.block_misfit = options_.block_misfit;
  job.needs_door_lock = options_.needs_door_lock;
  job.block_stage_mm = options_.block_stage_mm;
  job.position_tolerance_um = options_.block_stage_mm ? 30 : 0;
  job.earlier = std::move(opened->earlier);
  engraving = std::make_unique<Engraving>(
      std::move(job), *controller, *feed, *journal, chain,
      [this](const PulseResult& result) { results.push_back(result); });
}

void FakeCell::DieAndTakeUp(const std::function<void(const fs::path&)>& keep) {
  engraving.reset();
  journal.reset();
  feed.reset();
  controller.reset();
  if (keep) keep(journal_file);
  // The job service counts commands, and publishes the number also of what it withdrew.
  if (grant.number == 0) grant.number = 1;
  if (acts_as_job_service && permission_granted) LosePermission(true);
  Begin(JobBegun::kItsPathIsThere);
}

FakeCell::~FakeCell() {
  journal.reset();
  std::error_code ignored;
  fs::remove(journal_file, ignored);
}

std::unique_ptr<link::ByteStream> FakeCell::LineEnd(bool host) {
  return std::make_unique<link::FaultyEnd>(host ? to_host : to_laser,
                                           host ? to_laser : to_host, random_,
                                           [this] { return now; });
}

void FakeCell::AwaitLaser() {
  for (int i = 0; i < 1000 && !controller->up(); ++i) {
    now += 1ms;
    Poll();
  }
  const EngravingInputs inputs = Inputs();
  chain.Watch(LinksOf(inputs, inputs.motion, *controller, 0), now);
}

void FakeCell::Step() {
  now += 1ms;
  if (powered_again_at_.count() >= 0 && now >= powered_again_at_) {
    powered_again_at_ = -1ns;
    CutLine(false);
    laser.PowerCycle(LineEnd(false));
  }
  Poll();
  engraving->Turn(Inputs());
  if (acts_as_job_service) ActAsJobService();
  while (wait_for_disk && !journal->failed() &&
         journal->durable() < journal->appended()) {
    journal->Flush();
    std::this_thread::yield();
  }
}

void FakeCell::Poll() {
  PassTicks();
  laser.Poll();
  stage.Poll(now, laser.tick());
  const auto take = [this](const auto& report) {
    if (engraving) engraving->Receive(report);
  };
  controller->Poll(take, take);
}

// As Arming::TakePaused and JobArm::Renew, in services/job_service/queue.
void FakeCell::ActAsJobService() {
  if (now >= renewed_at_) {
    const int before = renewals_;
    RenewGrant();
    renewals_ = before + 1;
  }
  const bool fault = engraving->waits() && engraving->faulted();
  if (!fault || !permission_granted || now < granted_at_ + kHold) return;
  LosePermission(engraving->lost_a_line());
}

void FakeCell::LosePermission(bool is_renewed) {
  Withdraw();
  if (laser.cracks().size() != made_at_loss_) renewals_ = 0;
  made_at_loss_ = laser.cracks().size();
  if (!is_renewed || renewals_ >= kMaxRenewals) return;
  const std::chrono::nanoseconds wait = kHold * (1 << std::min(renewals_, 8));
  renewed_at_ = now + std::min<std::chrono::nanoseconds>(3s, wait);
}

void FakeCell::PassTicks() {
  if (powered_again_at_.count() >= 0) {
    next_tick_ = now + kPeriod;
    return;
  }
  for (int i = 0; i < lockstep_ticks_a_step; ++i) {
    const bool may = laser.lockstep()
                         ? laser.MayPassTick() && stage.MayPassTick(laser.tick() + 1)
                         : now >= next_tick_;
    if (!may) return;
    next_tick_ += kPeriod;
    stage.AdvanceTick(laser.tick() + 1);
    laser.AdvanceTick(stage.in_position(), stage.at_mm());
    on_tick(laser.tick());
  }
}

EngravingInputs FakeCell::Inputs() {
  EngravingInputs inputs;
  inputs.now = now;
  inputs.permission_fresh = permission_fresh;
  inputs.permission_granted = permission_granted;
  inputs.grant = grant;
  inputs.stop_pressed = stop_pressed;
  inputs.speed_percent = speed_percent;
  inputs.first_point = first_point;
  inputs.fire_uncertain = fire_uncertain;
  inputs.motion = stage.view();
  if (!stage.silent) view_at_ = now;
  inputs.motion_clock = motion_clock;
  inputs.motion.fresh = now - view_at_ < kMotionLease;
  inputs.motion.answers = !bridge_ended;
  inputs.motion.has_block_stage = reports_block && options_.block_stage_mm.has_value();
  inputs.motion.block_mm = block_mm;
  inputs.stage_approaches = block_drives;
  inputs.block_failure = std::exchange(block_failure, {});
  return inputs;
}

void FakeCell::StepFor(milliseconds time) {
  for (const auto end = now + time; now < end;) Step();
}

bool FakeCell::StepUntil(const std::function<bool()>& condition, milliseconds limit) {
  for (const auto end = now + limit; now < end && !condition();) Step();
  return condition();
}

void FakeCell::GrantAnew() {
  Withdraw();
  StepFor(5ms);
  // Who arms before the laser answers has to do it again.
  StepUntil([this] { return controller->up(); }, 300ms);
  StepFor(5ms);
  Grant();
}

void FakeCell::CutLineOverForgottenPulses() {
  laser.forgets = true;
  CutLine(true);
  StepFor(1000ms);
  CutLine(false);
  StepUntil([this] { return Count(PointState::kArmed) == 0; });
  laser.forgets = false;
}

void FakeCell::LeaveOutSyncs(std::uint32_t count) {
  next_tick_ += count * kPeriod;
  stage.MoveOn(count);
}

void FakeCell::CutLine(bool cut) { to_laser->cut = to_host->cut = cut; }

void FakeCell::PowerCycle(milliseconds time) {
  CutLine(true);
  powered_again_at_ = now + time;
}

std::string FakeCell::Description() const {
  const link::LaserStatus& status = controller->status();
  const MotionView& view = stage.view();
  return fmt::format(
      "phase {} '{}', tick {} (reported {}, decided {}), interlocks {:#x}, shutters {}, "
      "{} "
      "made, {} armed; stage: run {} of {}, at rest {}, fault {}, covered {}; line up {}",
      static_cast<int>(phase()), engraving->message(), laser.tick(), status.tick,
      status.decided_through, status.interlocks, status.shutters_open, made(),
      Count(PointState::kArmed), view.run, view.highest_run, view.at_rest,
      static_cast<int>(view.fault), view.covered_through_tick, controller->up());
}

formats::Journal FakeCell::JournalOnDisk() const {
  while (!journal->failed() && journal->durable() < journal->appended()) {
    journal->Flush();
    std::this_thread::yield();
  }
  return *formats::ReadJournal(journal_file);
}

std::vector<std::string> FakeCell::Disagreements() const {
  std::vector<std::string> wrong;
  CheckGlass(wrong);
  CheckJournal(wrong);
  return wrong;
}

// Every crack lies at a point and in its channels, none is doubled, and the ledger knows
// of it.
void FakeCell::CheckGlass(std::vector<std::string>& wrong) const {
  std::map<std::uint32_t, std::vector<Crack>> at_point;
  for (const Crack& crack : laser.cracks()) {
    const auto found =
        std::find_if(points_mm.begin(), points_mm.end(), [&](const Vec3& p) {
          return (p - crack.at_mm).norm() < 1e-6;  // of um positions in double
        });
    if (found == points_mm.end()) {
      wrong.push_back(fmt::format("tick {} fired at no point", crack.tick));
    } else {
      const auto point = static_cast<std::uint32_t>(found - points_mm.begin());
      at_point[point].push_back(crack);
      const ChannelMask meant =
          options_.masks.empty() ? ChannelMask{1} : options_.masks.at(point);
      if (crack.channels != meant) {
        wrong.push_back(fmt::format("point {} of channels {:#x} fired in {:#x}", point,
                                    meant, crack.channels));
      }
    }
  }
  // By a person's consent, each time once more.
  std::vector<std::size_t> allowed(points_mm.size(), 1);
  for (const formats::JournalRecord& record : JournalOnDisk().records) {
    if (record.kind == JournalKind::kReopened) ++allowed[record.point];
  }
  std::uint64_t sum = 0;
  for (std::uint32_t i = 0; i < points_mm.size(); ++i) {
    const PointState state = engraving->ledger().state(i);
    const auto found = at_point.find(i);
    const std::size_t count = found == at_point.end() ? 0 : found->second.size();
    sum += state != PointState::kArmed ? 1 : 0;
    if (count > allowed[i])
      wrong.push_back(fmt::format("point {} fired {} times", i, count));
    const bool claimed = state == PointState::kMade || state == PointState::kMissed;
    const bool open = state == PointState::kUncertain || state == PointState::kArmed;
    const bool known = !open && (claimed || allowed[i] == 1);
    if (known && claimed != (count > 0)) {
      wrong.push_back(fmt::format("point {} is in state {} and fired {} times", i,
                                  static_cast<int>(state), count));
    }
  }
  if (done() && sum != points_mm.size()) {
    wrong.push_back(fmt::format("{} of {} points have an end", sum, points_mm.size()));
  }
}

// Intent, then one outcome, for each arming; every crack has an intent of its tick.
void FakeCell::CheckJournal(std::vector<std::string>& wrong) const {
  const formats::Journal journal_now = JournalOnDisk();
  std::map<std::uint32_t, PointState> last;
  std::set<std::uint32_t> open;
  std::set<std::pair<std::uint64_t, std::uint32_t>> intents;
  for (const formats::JournalRecord& record : journal_now.records) {
    if (!formats::IsOfPoint(record.kind)) continue;
    if (record.kind == JournalKind::kReopened) {
      if (last[record.point] != PointState::kUncertain || open.contains(record.point)) {
        wrong.push_back(
            fmt::format("point {} is opened again and was not uncertain", record.point));
      }
      last[record.point] = PointState::kPlanned;
      continue;
    }
    const bool intent = record.kind == JournalKind::kIntent;
    if (record.outcome == PointOutcome::kLeftOut) {
      last[record.point] = PointState::kLeftOut;
      continue;
    }
    if (intent != open.insert(record.point).second) {
      wrong.push_back(fmt::format("point {}: {} out of turn at tick {}", record.point,
                                  intent ? "intent" : "outcome", record.tick));
    }
    if (intent) {
      intents.emplace(record.tick, record.point);
      continue;
    }
    open.erase(record.point);
    last[record.point] = StateOf(record.outcome);
  }
  for (std::uint32_t i = 0; i < points_mm.size(); ++i) {
    const PointState state = engraving->ledger().state(i);
    if (open.contains(i) != (state == PointState::kArmed)) {
      wrong.push_back(fmt::format("point {} is in state {}, its intent is {}", i,
                                  static_cast<int>(state),
                                  open.contains(i) ? "open" : "closed"));
    } else if (state != PointState::kArmed && last[i] != state) {
      wrong.push_back(fmt::format("point {}: ledger {}, journal {}", i,
                                  static_cast<int>(state), static_cast<int>(last[i])));
    }
  }
  for (const Crack& crack : laser.cracks()) {
    const bool meant =
        std::any_of(intents.begin(), intents.end(), [&](const auto& intent) {
          return intent.first == crack.tick &&
                 (points_mm[intent.second] - crack.at_mm).norm() < 1e-6;
        });
    if (!meant) wrong.push_back(fmt::format("tick {} fired without intent", crack.tick));
  }
}

}  // namespace intaglio::synchronizer
