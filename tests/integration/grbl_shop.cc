#include "tests/integration/grbl_shop.h"

#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <sstream>

#include "engrave/formats/journal_file.h"
#include "engrave/formats/point_file.h"
#include "tests/integration/course/flashes.h"
#include "tests/test_folder.h"

namespace intaglio::testing {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

constexpr char kDomain[] = "49";

std::string JobOf(const std::string& mesh, const std::string& placement, double height_mm,
                  double spacing_mm) {
  std::ostringstream job;
  job << "models { file: \"" << mesh << "\" placement { " << placement
      << " fit_height_mm: " << height_mm << " } }\n"
      << "block { size_mm { x: 50 y: 50 z: 30 } }\n"
      << "discretization { min_spacing_mm: " << spacing_mm << " }\n";
  return job.str();
}

/// The point's outcome that the journal has last, by place in the order.
std::vector<formats::PointOutcome> LastOutcomes(const formats::Journal& journal,
                                                std::size_t count) {
  std::vector<formats::PointOutcome> last(count, formats::PointOutcome::kNone);
  for (const formats::JournalRecord& one : journal.records) {
    if (one.kind == formats::JournalKind::kOutcome) last.at(one.point) = one.outcome;
  }
  return last;
}

}  // namespace

std::string GrblShop::Knot(double height_mm) {
  return JobOf(INTAGLIO_SOURCE_DIR "/deploy/jobs/sample.obj", "", height_mm, 0.3);
}

std::string GrblShop::Mesh(const fs::path& file, double height_mm, double spacing_mm) {
  return JobOf(file.string(), "rotate_deg { x: 90 }", height_mm, spacing_mm);
}

GrblShop::GrblShop(const Options& options)
    : folder_(test::FreshFolder()),
      tag_("grbl" + std::to_string(getpid())),
      socket_("/tmp/grbl" + std::to_string(getpid())) {
  const std::string line = options.tcp ? "tcp:127.0.0.1:0" : (folder_ / "line").string();
  std::vector<std::string> arguments = {"--line", line, "--record",
                                        (folder_ / "record.txt").string()};
  if (options.hal) arguments.emplace_back("--hal");
  controller_ = std::make_unique<Running>(
      fs::path(INTAGLIO_BIN_DIR).parent_path() / "tests/virtual-grbl", arguments,
      folder_ / "controller.log");
  Eventually([this] { return controller_->Output().find('\n') != std::string::npos; },
             10s);
  std::istringstream ready(controller_->Output());
  std::string word, device;
  ready >> word >> device;
  EXPECT_EQ(word, "ready") << controller_->Output();
  fs::create_directory(socket_);
  fs::permissions(socket_, fs::perms::owner_all);
  WriteProfile(device);
  std::ofstream(folder_ / "job.textproto")
      << "name: \"job\"\nglass: \"N-BK7\"\n"
      << options.job << "laser { photosensor_feedback: false rate_hz: 100 }\n"
      << "machine_file: \"shop/machine.textproto\"\n";
}

GrblShop::~GrblShop() {
  if (IsOpen()) {
    shop_->Signal(SIGTERM);
    shop_->WaitForEnd(20s);
  }
  std::error_code ignored;
  fs::remove_all(socket_, ignored);
}

// The supplied one, with these lines and a lamp that is warm at once.
void GrblShop::WriteProfile(const std::string& device) const {
  std::ifstream in(INTAGLIO_SOURCE_DIR "/deploy/machines/grbl.textproto");
  std::ofstream out(profile());
  for (std::string line; std::getline(in, line);) {
    if (line.starts_with("motion_line")) {
      line = "motion_line { protocol: \"grbl\" device: \"" + device +
             "\" serial_number: \"G-03\" }";
    } else if (line.starts_with("laser_line")) {
      line = "laser_line { protocol: \"motion-output\" device: \"unix:" + socket_ +
             "/laser\" }";
    } else if (line.find("warm_up_s") != std::string::npos) {
      line = "  warm_up_s: 0";
    }
    out << line << '\n';
  }
}

std::string GrblShop::Type(std::vector<std::string> arguments) {
  arguments.insert(arguments.end(), {"--domain", kDomain, "--tag", tag_});
  Running run(Program("intaglio"), arguments, folder_ / "typed.txt");
  return run.WaitForEnd(60s).output;
}

bool GrblShop::Open() {
  shop_.reset();
  shop_ = std::make_unique<Running>(
      Program("intaglio"),
      std::vector<std::string>{"up", "--real-machine", "--machine", profile().string(),
                               "--folder", (folder_ / "shop").string(), "--materials",
                               (folder_ / "materials.db").string(), "--block", "50", "50",
                               "30", "--block-glass", "N-BK7", "--domain", kDomain,
                               "--tag", tag_},
      folder_ / ("shop" + std::to_string(++opened_) + ".log"));
  return Eventually(
             [this] {
               return !shop_->running() ||
                      shop_->Output().find("the shop is open") != std::string::npos;
             },
             60s) &&
         shop_->running();
}

bool GrblShop::Submit() {
  return Type({"submit", (folder_ / "job.textproto").string(), "--arm"}).find("job 1") !=
         std::string::npos;
}

bool GrblShop::AwaitDone(std::chrono::seconds bound, bool resuming) {
  return Eventually(
      [&] {
        if (resuming && !IsOpen() && !Open()) return false;
        shown_ = Type({"show", "1"});
        if (resuming && shown_.find("state      paused") != std::string::npos) {
          // A line that was lost with the stage at the zero of its axes, where a job
          // begins, counts as a power-up; a person finds it there.
          if (shown_.find("teach zero") != std::string::npos) Type({"teach", "zero"});
          Type({"resume", "1"});
        }
        return shown_.find("state      done") != std::string::npos;
      },
      bound);
}

int GrblShop::Kill(const std::string& service) const {
  int killed = 0;
  for (const pid_t process : ProcessesWith({"/" + service, tag_})) {
    killed += kill(process, SIGKILL) == 0;
  }
  return killed;
}

std::size_t GrblShop::Flashes() const {
  std::ifstream record(folder_ / "record.txt");
  std::size_t count = 0;
  for (std::string line; std::getline(record, line);) count += line.starts_with("flash");
  return count;
}

fs::path GrblShop::JobFolder() const {
  for (const auto& entry : fs::directory_iterator(folder_ / "shop/jobs")) {
    if (entry.path().filename().string().starts_with("1-")) return entry.path();
  }
  return {};
}

std::size_t GrblShop::UncertainPoints() const {
  const auto path = formats::ReadPly(JobFolder() / "path.ply");
  const auto journal = formats::ReadJournal(JobFolder() / "journal.bin");
  if (!path || !journal) return 0;
  const auto last = LastOutcomes(*journal, path->points_mm.size());
  return static_cast<std::size_t>(
      std::count(last.begin(), last.end(), formats::PointOutcome::kUncertain));
}

GrblJudgement GrblShop::Judge() const {
  GrblJudgement judgement;
  const fs::path job = JobFolder();
  const auto path = formats::ReadPly(job / "path.ply");
  const auto journal = formats::ReadJournal(job / "journal.bin");
  EXPECT_TRUE(path && journal);
  if (!path || !journal) return judgement;
  const FlashRecord record = ReadFlashes(folder_ / "record.txt");
  judgement.lit_at_rest_us = record.lit_at_rest_us;
  const PointList &points = path->points_mm, &flashes = record.began_mm;
  const HeightFit fit = FitHeight(points, flashes);
  judgement.points = points.size();
  std::vector<int> count(points.size(), 0);
  for (const Vec3& flash : flashes) {
    double nearest_mm = 1e9;
    std::size_t nearest = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
      const double off_mm = (fit.AxesAt(points[i]) - flash).cwiseAbs().maxCoeff();
      if (off_mm < nearest_mm) nearest_mm = off_mm, nearest = i;
    }
    judgement.farthest_mm = std::max(judgement.farthest_mm, nearest_mm);
    judgement.stray += nearest_mm > 0.05;
    ++count[nearest];
  }
  const auto last = LastOutcomes(*journal, points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    const bool uncertain = last[i] == formats::PointOutcome::kUncertain;
    judgement.made += count[i] > 0;
    judgement.doubled += count[i] > 1;
    judgement.uncertain += uncertain;
    judgement.unknown += !uncertain && formats::IsFired(last[i]) != (count[i] > 0);
  }
  return judgement;
}

}  // namespace intaglio::testing
