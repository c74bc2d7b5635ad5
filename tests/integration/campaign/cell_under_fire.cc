#include "tests/integration/campaign/cell_under_fire.h"

#include <fcntl.h>
#include <signal.h>

#include <cmath>
#include <fstream>
#include <iostream>
#include <map>

#include "engrave/formats/glass_record.h"
#include "engrave/formats/journal_file.h"
#include "engrave/formats/point_file.h"
#include "services/client/shop/virtual_truth.h"
#include "services/job/files/job_file.h"
#include "services/virtual_engraver/truth/truth_file.h"

namespace intaglio::campaign {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using formats::PointOutcome;
using testing::Eventually;
using testing::Program;
using testing::Running;

constexpr int kDomain = 48;
// A crack within this of a point is the point's; neighbours are ten times as far.
constexpr double kNearMm = 0.03;

fs::path SourceFolder() { return INTAGLIO_SOURCE_DIR; }

fs::path SuppliedProfile(const std::string& name) {
  return SourceFolder() / "deploy/machines" / (name + ".textproto");
}

/// That of the profile over a block as the jobs have it, with a lamp that is warm.
MachineTruth TruthOfProfile(const std::string& name) {
  const MachineSpec machine = ReadMachineFile(SuppliedProfile(name)).value();
  MountedParts mounted;
  mounted.block_mm = Vec3(50, 50, 30);
  mounted.refractive_index = 1.51947;
  mounted.lens = MountedLens("", machine).value_or(std::nullopt);
  if (!mounted.lens && machine.lenses_size() > 0)
    mounted.lens = MountedLens(machine.lenses(0).name(), machine).value();
  MachineTruth truth = client::TruthOf(machine, mounted);
  truth.mutable_laser()->set_warm_up_s(0);
  return truth;
}

/// A supplied profile, with its lines at the virtual machine.
void WriteProfile(const std::string& name, const fs::path& file, const fs::path& laser,
                  const fs::path& motion) {
  std::ifstream in(SuppliedProfile(name));
  std::ofstream out(file);
  for (std::string line; std::getline(in, line);) {
    if (line.starts_with("laser_line") || line.starts_with("motion_line")) continue;
    out << line << '\n';
  }
  out << "laser_line { protocol: \"virtual-laser\" device: \"" << laser.string()
      << "\" baud: 115200 }\n"
      << "motion_line { protocol: \"virtual-stage\" device: \"" << motion.string()
      << "\" baud: 115200 }\n";
}

std::size_t SizeOf(const fs::path& file) {
  std::error_code error;
  const auto size = fs::file_size(file, error);
  return error ? 0 : size;
}

std::size_t CracksIn(const fs::path& glass) {
  const std::size_t size = SizeOf(glass);
  return size < formats::kGlassHeaderSize
             ? 0
             : (size - formats::kGlassHeaderSize) / formats::kGlassRecordSize;
}

}  // namespace

CellUnderFire::CellUnderFire(fs::path folder, std::string tag, const std::string& speed,
                             std::string profile)
    : folder_(std::move(folder)),
      tag_(std::move(tag)),
      speed_(speed),
      profile_(std::move(profile)) {
  fs::create_directories(folder_);
  WriteProfile(profile_, folder_ / "machine.textproto", folder_ / "laser",
               folder_ / "motion");
  StartMachine(folder_ / "glass.rec");
}

void CellUnderFire::StartMachine(const fs::path& glass) {
  if (const auto written =
          WriteTruthFile(folder_ / "truth.textproto", TruthOfProfile(profile_));
      !written)
    std::cerr << written.error().message << "\n";
  machine_ = std::make_unique<Running>(
      Program("virtual-engraver"),
      std::vector<std::string>{"--truth", (folder_ / "truth.textproto").string(),
                               "--laser-line", (folder_ / "laser").string(),
                               "--motion-line", (folder_ / "motion").string(), "--panel",
                               (folder_ / "panel").string(), "--glass-record",
                               glass.string(), "--speed", speed_},
      folder_ / "machine.log");
  Eventually([this] { return fs::exists(folder_ / "motion"); }, 10s);
}

void CellUnderFire::ChangeTheBlockOfADeadMachine() {
  machine_->Signal(SIGKILL);
  machine_->WaitForEnd(5s);
  for (const char* line : {"laser", "motion", "panel"}) fs::remove(folder_ / line);
  StartMachine(folder_ / "next_block.rec");
}

std::size_t CellUnderFire::CracksOfTheNextBlock() const {
  return CracksIn(folder_ / "next_block.rec");
}

CellUnderFire::~CellUnderFire() {
  for (const auto& watcher : watchers_) watcher->Signal(SIGKILL);
  if (!shop_) return;
  shop_->Signal(SIGTERM);
  shop_->WaitForEnd(20s);
}

std::vector<std::string> CellUnderFire::OnTheBus(std::vector<std::string> words) const {
  words.insert(words.end(), {"--domain", std::to_string(kDomain), "--tag", tag_});
  return words;
}

bool CellUnderFire::OpenShop() {
  shop_ = std::make_unique<Running>(
      Program("intaglio"),
      OnTheBus({"up", "--real-machine", "--machine",
                (folder_ / "machine.textproto").string(), "--folder",
                (folder_ / "shop").string(), "--materials",
                (folder_ / "materials.db").string()}),
      folder_ / "shop.log");
  return Eventually(
      [this] { return shop_->Output().find("the shop is open") != std::string::npos; },
      40s);
}

void CellUnderFire::KillShop() {
  for (const pid_t process : testing::ProcessesWith({"intaglio-", tag_})) {
    kill(process, SIGKILL);
  }
  shop_->Signal(SIGKILL);
}

void CellUnderFire::AwaitShopGone() {
  shop_->WaitForEnd(5s);
  const auto gone = [this] {
    return testing::ProcessesWith({"intaglio-", tag_}).empty();
  };
  Eventually(gone, 10s);
}

void CellUnderFire::CutJournal(std::uint32_t choice) const {
  constexpr std::size_t kLast = 64 * 1024;
  constexpr std::size_t kMin = formats::kJournalHeaderSize + formats::kJournalRecordSize;
  const fs::path file = JobFolder() / "journal.bin";
  const std::size_t size = SizeOf(file);
  if (size <= kMin) return;
  fs::resize_file(file, size - choice % std::min(kLast, size - kMin));
}

std::string CellUnderFire::Type(const std::vector<std::string>& words) {
  Running run(Program("intaglio"), OnTheBus(words),
              folder_ / ("typed" + std::to_string(++typed_ % 10) + ".txt"));
  return run.WaitForEnd(60s).output;
}

std::vector<std::string> CellUnderFire::SampleJob(
    const std::vector<std::string>& options) const {
  std::vector<std::string> words = {
      "submit",    (SourceFolder() / "deploy/jobs/sample.textproto").string(),
      "--height",  "3.2",
      "--machine", (folder_ / "shop/machine.textproto").string()};
  words.insert(words.end(), options.begin(), options.end());
  return words;
}

bool CellUnderFire::Submit(const std::string& rate_hz,
                           const std::vector<std::string>& options) {
  ++jobs_;
  cracks_before_ = Cracks();
  std::vector<std::string> words = SampleJob(options);
  words.insert(words.end(),
               {"--rate", rate_hz.empty() ? this->rate_hz() : rate_hz, "--arm"});
  return Type(words).find("job " + std::to_string(jobs_)) != std::string::npos;
}

void CellUnderFire::SubmitAnother(const std::vector<std::string>& options) {
  Type(SampleJob(options));
}

std::string CellUnderFire::Show() { return Type({"show", std::to_string(jobs_)}); }

std::string CellUnderFire::Press(const std::string& command) const {
  return testing::AskPanel(folder_, command);
}

bus::BusOptions CellUnderFire::bus_options() const {
  bus::BusOptions options;
  options.control_domain = kDomain;
  options.tag = tag_;
  return options;
}

void CellUnderFire::AddFrozenWatchers(int count) {
  for (int i = 0; i < count; ++i) {
    const auto output = folder_ / ("watcher" + std::to_string(i) + ".txt");
    watchers_.push_back(std::make_unique<Running>(
        Program("intaglio"), OnTheBus({"watch", std::to_string(jobs_), "--events"}),
        output));
  }
  for (std::size_t i = 0; i < watchers_.size(); ++i) {
    const auto output = folder_ / ("watcher" + std::to_string(i) + ".txt");
    Eventually([&] { return SizeOf(output) > 0; }, 10s);
    watchers_[i]->Signal(SIGSTOP);
  }
}

pid_t CellUnderFire::ProcessOf(const std::string& service) const {
  const auto found = testing::ProcessesWith({"/" + service, tag_});
  return found.empty() ? 0 : found.front();
}

std::size_t CellUnderFire::Cracks() const { return CracksIn(folder_ / "glass.rec"); }

bool CellUnderFire::AwaitCracks(std::size_t count,
                                std::chrono::milliseconds bound) const {
  return Eventually([&] { return Cracks() >= count; }, bound);
}

bool CellUnderFire::AwaitDone(std::chrono::seconds bound) {
  return AwaitEnd(bound, false);
}

bool CellUnderFire::AwaitDoneResuming(std::chrono::seconds bound) {
  return AwaitEnd(bound, true);
}

bool CellUnderFire::AwaitEnd(std::chrono::seconds bound, bool resuming) {
  return Eventually(
      [&] {
        const std::string shown = Show();
        if (resuming && shown.find("state      paused") != std::string::npos) {
          Type({"resume", std::to_string(jobs_)});
        }
        return shown.find("state      done") != std::string::npos;
      },
      bound);
}

fs::path CellUnderFire::JobFolder() const {
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder_ / "shop/jobs", error)) {
    const std::string name = entry.path().filename().string();
    if (name.starts_with(std::to_string(jobs_) + "-")) return entry.path();
  }
  return {};
}

// Written independently of the product's own proof: brute force, and the journal's last
// outcome of each point.
Verdict CellUnderFire::Judge() const {
  Verdict verdict;
  const auto path = formats::ReadPly(JobFolder() / "path.ply");
  const auto journal = formats::ReadJournal(JobFolder() / "journal.bin");
  const auto glass = formats::ReadGlassRecord(folder_ / "glass.rec");
  if (!path || !journal || !glass) {
    verdict.trouble = !path      ? path.error().message
                      : !journal ? journal.error().message
                                 : glass.error().message;
    return verdict;
  }
  verdict.points = path->points_mm.size();
  std::vector<int> cracks(verdict.points, 0);
  std::vector<std::uint64_t> crack_ticks(verdict.points, 0), ticks(verdict.points, 0);
  for (std::size_t at = cracks_before_; at < glass->cracks.size(); ++at) {
    const formats::GlassCrack& crack = glass->cracks[at];
    if (verdict.first_tick == 0) verdict.first_tick = crack.tick;
    verdict.last_tick = crack.tick;
    std::size_t nearest = verdict.points;
    for (std::size_t i = 0; i < verdict.points; ++i) {
      if ((path->points_mm[i] - crack.position_mm).norm() < kNearMm) nearest = i;
    }
    if (nearest == verdict.points) {
      ++verdict.stray;
    } else {
      ++cracks[nearest];
      crack_ticks[nearest] = crack.tick;
    }
  }
  std::vector<PointOutcome> last(verdict.points, PointOutcome::kNone);
  std::vector<bool> open(verdict.points, false);
  for (const formats::JournalRecord& record : journal->records) {
    if (!formats::IsOfPoint(record.kind)) continue;
    // This record adds no knowledge about the point.
    if (record.kind == formats::JournalKind::kReopened) continue;
    open.at(record.point) = record.kind == formats::JournalKind::kIntent;
    if (!open[record.point]) last[record.point] = record.outcome;
    if (!open[record.point]) ticks[record.point] = record.tick;
  }
  for (std::size_t i = 0; i < verdict.points; ++i) {
    verdict.made += cracks[i] > 0 ? 1 : 0;
    verdict.doubled += cracks[i] > 1 ? 1 : 0;
    const bool uncertain = open[i] || last[i] == PointOutcome::kUncertain;
    verdict.uncertain += uncertain ? 1 : 0;
    verdict.skipped += !uncertain && cracks[i] == 0 ? 1 : 0;
    if (!uncertain && formats::IsFired(last[i]) != (cracks[i] > 0)) ++verdict.unknown;
    if (!uncertain && cracks[i] == 1 && crack_ticks[i] != ticks[i]) ++verdict.mistimed;
  }
  return verdict;
}

}  // namespace intaglio::campaign
