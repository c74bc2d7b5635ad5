// A job through the product's processes and a controller of the grbl family: the virtual
// grbl in a process of its own, whose record of the laser is the judge.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <unistd.h>

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <random>
#include <sstream>

#include "engrave/formats/journal_file.h"
#include "engrave/formats/point_file.h"
#include "tests/integration/run_program.h"
#include "tests/test_folder.h"

namespace intaglio {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using testing::Eventually;
using testing::Program;
using testing::Running;

// A step of the virtual grbl, and half a one of rounding.
constexpr double kStepMm = 0.004;

class GrblJob : public ::testing::Test {
 protected:
  struct Judgement {
    std::size_t points = 0, made = 0, doubled = 0, stray = 0, uncertain = 0;
    std::size_t unknown = 0;  ///< fired, and neither known nor uncertain
    double lit_at_rest_us = 0, farthest_mm = 0;
  };

  GrblJob() : folder_(test::FreshFolder()), tag_("grbl" + std::to_string(getpid())) {
    controller_ = std::make_unique<Running>(
        fs::path(INTAGLIO_BIN_DIR).parent_path() / "tests/virtual-grbl",
        std::vector<std::string>{"--line", (folder_ / "line").string(), "--record",
                                 (folder_ / "record.txt").string(), "--hal"},
        folder_ / "controller.log");
    Eventually([this] { return fs::exists(folder_ / "line"); }, 10s);
    fs::create_directory(socket_);
    fs::permissions(socket_, fs::perms::owner_all);
    WriteProfile();
    std::ofstream(folder_ / "job.textproto")
        << "name: \"knot\"\nmodels { file: \"" << INTAGLIO_SOURCE_DIR
        << "/deploy/jobs/sample.obj\" placement { fit_height_mm: 3.2 } }\n"
           "block { size_mm { x: 50 y: 50 z: 30 } }\nglass: \"N-BK7\"\n"
           "discretization { min_spacing_mm: 0.3 }\n"
           "laser { photosensor_feedback: false rate_hz: 100 }\n"
           "machine_file: \"shop/machine.textproto\"\n";
  }
  ~GrblJob() override {
    if (shop_) {
      shop_->Signal(SIGTERM);
      shop_->WaitForEnd(20s);
    }
    std::error_code ignored;
    fs::remove_all(socket_, ignored);
  }

  void WriteProfile() const {
    std::ifstream in(INTAGLIO_SOURCE_DIR "/deploy/machines/grbl.textproto");
    std::ofstream out(folder_ / "machine.textproto");
    for (std::string line; std::getline(in, line);) {
      if (line.starts_with("motion_line")) {
        line = "motion_line { protocol: \"grbl\" device: \"" +
               (folder_ / "line").string() + "\" serial_number: \"G-03\" }";
      } else if (line.starts_with("laser_line")) {
        line = "laser_line { protocol: \"motion-output\" device: \"unix:" + socket_ +
               "/laser\" }";
      } else if (line.find("warm_up_s") != std::string::npos) {
        line = "  warm_up_s: 0";
      }
      out << line << '\n';
    }
  }
  std::string Type(std::vector<std::string> arguments) {
    arguments.insert(arguments.end(), {"--domain", "49", "--tag", tag_});
    Running run(Program("intaglio"), arguments, folder_ / "typed.txt");
    return run.WaitForEnd(60s).output;
  }
  void OpenShop() {
    shop_ = std::make_unique<Running>(
        Program("intaglio"),
        std::vector<std::string>{
            "up", "--real-machine", "--machine", (folder_ / "machine.textproto").string(),
            "--folder", (folder_ / "shop").string(), "--materials",
            (folder_ / "materials.db").string(), "--domain", "49", "--tag", tag_},
        folder_ / "shop.log");
    ASSERT_TRUE(Eventually(
        [this] { return shop_->Output().find("the shop is open") != std::string::npos; },
        60s))
        << shop_->Output();
  }
  void Submit() {
    const std::string answer =
        Type({"submit", (folder_ / "job.textproto").string(), "--arm"});
    ASSERT_THAT(answer, ::testing::HasSubstr("job 1")) << answer;
  }
  bool AwaitDone(std::chrono::seconds bound, bool resuming) {
    return Eventually(
        [&] {
          shown_ = Type({"show", "1"});
          if (resuming && shown_.find("state      paused") != std::string::npos) {
            Type({"resume", "1"});
          }
          return shown_.find("state      done") != std::string::npos;
        },
        bound);
  }
  std::size_t Flashes() const {
    std::ifstream record(folder_ / "record.txt");
    std::size_t count = 0;
    for (std::string line; std::getline(record, line);)
      count += line.starts_with("flash");
    return count;
  }
  Judgement Judge() const;

  fs::path folder_;
  std::string tag_, shown_;
  // Of a short path: that of a socket has 107 bytes.
  std::string socket_ = "/tmp/grbl" + std::to_string(getpid());
  std::unique_ptr<Running> controller_, shop_;
};

/// Height of the axis for each point: glass refracts, so it goes linearly with the
/// point's own height; fitted on the flashes whose x and y have one point alone.
std::pair<double, double> HeightFit(const PointList& points, const PointList& flashes) {
  double n = 0, sx = 0, sy = 0, sxx = 0, sxy = 0;
  for (const Vec3& flash : flashes) {
    const Vec3* only = nullptr;
    int near = 0;
    for (const Vec3& point : points) {
      if ((point - flash).head<2>().norm() > 0.03) continue;
      ++near;
      only = &point;
    }
    if (near != 1) continue;
    n += 1, sx += only->z(), sy += flash.z();
    sxx += only->z() * only->z(), sxy += only->z() * flash.z();
  }
  const double slope = (n * sxy - sx * sy) / (n * sxx - sx * sx);
  return {slope, (sy - slope * sx) / n};
}

GrblJob::Judgement GrblJob::Judge() const {
  Judgement judgement;
  fs::path job;
  for (const auto& entry : fs::directory_iterator(folder_ / "shop/jobs")) {
    if (entry.path().filename().string().starts_with("1-")) job = entry.path();
  }
  const auto path = formats::ReadPly(job / "path.ply");
  const auto journal = formats::ReadJournal(job / "journal.bin");
  EXPECT_TRUE(path && journal);
  if (!path || !journal) return judgement;
  PointList flashes;
  std::ifstream record(folder_ / "record.txt");
  for (std::string line; std::getline(record, line);) {
    std::istringstream in(line);
    std::string kind;
    Vec3 at;
    if (in >> kind && kind == "rest") in >> judgement.lit_at_rest_us;
    if (kind == "flash" && in >> at.x() >> at.y() >> at.z()) flashes.push_back(at);
  }
  const PointList& points = path->points_mm;
  const auto [slope, offset] = HeightFit(points, flashes);
  judgement.points = points.size();
  std::vector<int> count(points.size(), 0);
  for (const Vec3& flash : flashes) {
    double nearest_mm = 1e9;
    std::size_t nearest = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Vec3 at(points[i].x(), points[i].y(), slope * points[i].z() + offset);
      const double off_mm = (at - flash).cwiseAbs().maxCoeff();
      if (off_mm < nearest_mm) nearest_mm = off_mm, nearest = i;
    }
    judgement.farthest_mm = std::max(judgement.farthest_mm, nearest_mm);
    judgement.stray += nearest_mm > 0.05;
    ++count[nearest];
  }
  std::vector<formats::PointOutcome> last(points.size(), formats::PointOutcome::kNone);
  for (const formats::JournalRecord& one : journal->records) {
    if (one.kind == formats::JournalKind::kOutcome) last.at(one.point) = one.outcome;
  }
  for (std::size_t i = 0; i < points.size(); ++i) {
    const bool uncertain = last[i] == formats::PointOutcome::kUncertain;
    judgement.made += count[i] > 0;
    judgement.doubled += count[i] > 1;
    judgement.uncertain += uncertain;
    judgement.unknown += !uncertain && formats::IsFired(last[i]) != (count[i] > 0);
  }
  return judgement;
}

TEST_F(GrblJob, EveryPointIsMadeOnceWithinAStep) {
  OpenShop();
  Submit();
  ASSERT_TRUE(AwaitDone(120s, false)) << shown_;
  const Judgement judgement = Judge();
  EXPECT_GT(judgement.points, 200U);
  EXPECT_EQ(judgement.made, judgement.points);
  EXPECT_EQ(judgement.doubled + judgement.stray + judgement.unknown, 0U);
  EXPECT_EQ(judgement.uncertain, 0U);
  EXPECT_LE(judgement.farthest_mm, 1.5 * kStepMm);
  EXPECT_EQ(judgement.lit_at_rest_us, 0);
  std::cout << "  " << judgement.points << " points, farthest "
            << 1000 * judgement.farthest_mm << " um\n";
}

// INTAGLIO_GRBL_KILLS: how many; each is of the bridge or of the synchronizer, by turns.
TEST_F(GrblJob, KillsLeaveFewUncertainPointsAndDoubleNone) {
  const char* asked = std::getenv("INTAGLIO_GRBL_KILLS");
  const int kills = asked != nullptr ? std::atoi(asked) : 4;
  OpenShop();
  Submit();
  std::mt19937 random(7);
  int killed = 0;
  for (int i = 0; i < kills; ++i) {
    const std::size_t before = Flashes();
    if (!Eventually([&] { return Flashes() > before + random() % 30; }, 20s)) {
      if (AwaitDone(1s, true)) break;
      continue;
    }
    const char* service = i % 2 == 0 ? "intaglio-motion-bridge" : "intaglio-synchronizer";
    for (const pid_t process :
         testing::ProcessesWith({std::string("/") + service, tag_})) {
      killed += kill(process, SIGKILL) == 0;
    }
    (void)AwaitDone(2s, true);
  }
  ASSERT_TRUE(AwaitDone(180s, true)) << shown_;
  const Judgement judgement = Judge();
  EXPECT_GT(killed, 0);
  EXPECT_EQ(judgement.doubled, 0U);
  EXPECT_EQ(judgement.stray, 0U);
  EXPECT_EQ(judgement.unknown, 0U);
  EXPECT_LE(judgement.uncertain, 16U * static_cast<unsigned>(killed));
  EXPECT_EQ(judgement.lit_at_rest_us, 0);
  EXPECT_LE(judgement.farthest_mm, 1.5 * kStepMm);
  std::cout << "  " << killed << " kills, " << judgement.points << " points, "
            << judgement.made << " made, " << judgement.uncertain << " uncertain\n";
}

}  // namespace
}  // namespace intaglio
