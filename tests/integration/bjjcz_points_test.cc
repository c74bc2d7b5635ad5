// Points in glass through all processes at a virtual BJJCZ board, whose own record is the
// judge. Its places become places in the glass by a ray trace of this test's own.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <unistd.h>

#include <cmath>
#include <fstream>
#include <memory>
#include <sstream>
#include <thread>

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

// The supplied profile has these; N-BK7 at 355 nm (Schott's Sellmeier coefficients).
constexpr double kFieldMm = 110, kPupilMm = 224, kStepsPerMm = 400, kIndex = 1.538155;
constexpr double kHalfBlockMm = 25, kBlockHeightMm = 30, kZStepMm = 0.066;
constexpr std::size_t kListPoints = 150;

/// Where a beam that is aimed at a place of the field, so far below the face, is in
/// focus: in the middle between its sagittal and its tangential focus, which neighbouring
/// rays have by Snell's law.
Vec3 FocusInGlass(const Vec2& field_mm, double below_mm) {
  const auto in_glass = [](double angle) { return std::asin(std::sin(angle) / kIndex); };
  const double across_mm = field_mm.norm(), angle = std::atan(across_mm / kPupilMm);
  constexpr double kNear = 1e-4;
  const double tangential_mm =
      below_mm * (std::tan(angle + kNear) - std::tan(angle - kNear)) /
      (std::tan(in_glass(angle + kNear)) - std::tan(in_glass(angle - kNear)));
  const double sagittal_mm = angle > 1e-6
                                 ? below_mm * std::tan(angle) / std::tan(in_glass(angle))
                                 : tangential_mm;
  const double depth_mm = (sagittal_mm + tangential_mm) / 2;
  const double aside_mm =
      depth_mm * std::tan(in_glass(angle)) - below_mm * std::tan(angle);
  const Vec2 at_mm =
      across_mm > 0 ? Vec2(field_mm * (1 + aside_mm / across_mm)) : field_mm;
  return {at_mm.x() + kHalfBlockMm, at_mm.y() + kHalfBlockMm, kBlockHeightMm - depth_mm};
}

class BoardPoints : public ::testing::Test {
 protected:
  BoardPoints() : folder_(test::FreshFolder()), tag_("lmc" + std::to_string(getpid())) {
    board_ = std::make_unique<Running>(
        fs::path(INTAGLIO_BIN_DIR).parent_path() / "tests/virtual-bjjcz",
        std::vector<std::string>{"--line", (folder_ / "line").string(), "--record",
                                 (folder_ / "record.txt").string(), "--panel",
                                 (folder_ / "panel").string(), "--axis", "400"},
        folder_ / "board.log");
    Eventually([this] { return fs::exists(folder_ / "line"); }, 10s);
    fs::create_directory(socket_);
    fs::permissions(socket_, fs::perms::owner_all);
    WriteProfile();
    std::ofstream(folder_ / "job.textproto")
        << "name: \"knot\"\nmodels { file: \"" << INTAGLIO_SOURCE_DIR
        << "/deploy/jobs/sample.obj\" placement { fit_height_mm: 6 } }\n"
           "block { size_mm { x: 50 y: 50 z: 30 } }\nglass: \"N-BK7\"\n"
           "discretization { min_spacing_mm: 0.3 }\n"
           "laser { photosensor_feedback: false }\n"
           "machine_file: \"shop/machine.textproto\"\n";
  }
  ~BoardPoints() override {
    if (shop_) {
      shop_->Signal(SIGTERM);
      shop_->WaitForEnd(20s);
    }
    std::error_code ignored;
    fs::remove_all(socket_, ignored);
  }

  void WriteProfile() const {
    std::ifstream in(INTAGLIO_SOURCE_DIR "/deploy/machines/bjjcz-glass.textproto");
    std::ofstream out(folder_ / "machine.textproto");
    for (std::string line; std::getline(in, line);) {
      if (line.starts_with("motion_line")) {
        line = "motion_line { protocol: \"bjjcz\" device: \"" +
               (folder_ / "line").string() + "\" }";
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
            (folder_ / "materials.db").string(), "--block", "50", "50", "30",
            "--block-glass", "N-BK7", "--domain", "49", "--tag", tag_},
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
          if (resuming && shown_.find("state      paused") != std::string::npos)
            Type({"resume", "1"});
          return shown_.find("state      done") != std::string::npos;
        },
        bound);
  }
  void AtPanel(const std::string& command) const {
    EXPECT_EQ(testing::AskPanel(folder_, command), "ok\n") << command;
  }
  /// In the glass, in the order in which the board made them.
  PointList Flashes() const {
    PointList made_mm;
    std::ifstream record(folder_ / "record.txt");
    for (std::string line; std::getline(record, line);) {
      std::istringstream in(line);
      std::string kind;
      double x = 0, y = 0, axis = 0;
      if (!(in >> kind >> x >> y >> axis) || kind != "flash") continue;
      made_mm.push_back(FocusInGlass(Vec2(x - 32768, y - 32768) * kFieldMm / 65536,
                                     kBlockHeightMm - (axis / kStepsPerMm - 1)));
    }
    return made_mm;
  }

  struct Judgement {
    std::size_t points = 0, flashes = 0, doubled = 0, stray = 0, missing = 0,
                uncertain = 0, made_unknown = 0;
    double beside_um = 0, above_um = 0;  ///< the farthest
  };
  Judgement Judge() const;

  fs::path folder_;
  std::string tag_, shown_;
  // The path of a socket has 107 bytes at most.
  std::string socket_ = "/tmp/lmc" + std::to_string(getpid());
  std::unique_ptr<Running> board_, shop_;
};

// A flash belongs to the nearest point.
BoardPoints::Judgement BoardPoints::Judge() const {
  Judgement judgement;
  fs::path job;
  for (const auto& entry : fs::directory_iterator(folder_ / "shop/jobs")) {
    if (entry.path().filename().string().starts_with("1-")) job = entry.path();
  }
  const auto path = formats::ReadPly(job / "path.ply");
  const auto journal = formats::ReadJournal(job / "journal.bin");
  EXPECT_TRUE(path && journal);
  if (!path || !journal) return judgement;
  judgement.points = path->points_mm.size();
  std::vector<int> made(judgement.points, 0);
  for (const Vec3& flash : Flashes()) {
    ++judgement.flashes;
    std::size_t nearest = 0;
    for (std::size_t i = 0; i < judgement.points; ++i) {
      if ((path->points_mm[i] - flash).norm() < (path->points_mm[nearest] - flash).norm())
        nearest = i;
    }
    const Vec3 by_um = 1000 * (flash - path->points_mm[nearest]);
    judgement.stray += by_um.norm() > 100;
    judgement.beside_um = std::max(judgement.beside_um, by_um.head<2>().norm());
    judgement.above_um = std::max(judgement.above_um, std::abs(by_um.z()));
    judgement.doubled += ++made[nearest] > 1;
  }
  std::vector<formats::PointOutcome> last(judgement.points, formats::PointOutcome::kNone);
  for (const formats::JournalRecord& one : journal->records) {
    if (one.kind == formats::JournalKind::kOutcome) last.at(one.point) = one.outcome;
  }
  for (std::size_t i = 0; i < last.size(); ++i) {
    const bool uncertain = last[i] == formats::PointOutcome::kUncertain;
    judgement.uncertain += uncertain;
    judgement.missing += !uncertain && made[i] == 0;
    judgement.made_unknown += last[i] == formats::PointOutcome::kNone;
  }
  return judgement;
}

TEST_F(BoardPoints, EachIsMadeOnceAndInItsPlace) {
  OpenShop();
  Submit();
  ASSERT_TRUE(AwaitDone(240s, false)) << shown_;
  const Judgement judgement = Judge();
  EXPECT_GT(judgement.points, 300U);
  EXPECT_EQ(judgement.flashes, judgement.points);
  EXPECT_EQ(judgement.doubled + judgement.stray + judgement.missing +
                judgement.uncertain + judgement.made_unknown,
            0U);
  // Half a place of the board on both axes is 1.2 um.
  EXPECT_LT(judgement.beside_um, 2.5);
  // Half a step of z in the glass, its own steps, and the spherical aberration.
  EXPECT_LT(judgement.above_um, 1000 * (kZStepMm / 2 + 0.5 / kStepsPerMm) * kIndex + 10);
  std::cout << "  " << judgement.points << " points, " << judgement.beside_um
            << " um beside, " << judgement.above_um << " um above or below\n";
}

TEST_F(BoardPoints, KillsAndAPulledCableDoubleNoPoint) {
  OpenShop();
  Submit();
  const std::vector<std::string> victims = {"/intaglio-synchronizer",
                                            "/intaglio-motion-bridge", "cable",
                                            "/intaglio-job-service"};
  std::size_t inflicted = 0;
  for (const std::string& victim : victims) {
    const std::size_t before = Flashes().size();
    if (!Eventually([&] { return Flashes().size() > before + 40; }, 30s)) break;
    if (victim == "cable") {
      AtPanel("unplug");
      std::this_thread::sleep_for(1s);
      AtPanel("plug");
      ++inflicted;
    } else {
      for (const pid_t process : testing::ProcessesWith({victim, tag_}))
        inflicted += kill(process, SIGKILL) == 0;
    }
    (void)AwaitDone(5s, true);
  }
  ASSERT_TRUE(AwaitDone(240s, true)) << shown_;
  const Judgement judgement = Judge();
  EXPECT_GT(inflicted, 1U);
  EXPECT_EQ(
      judgement.doubled + judgement.stray + judgement.missing + judgement.made_unknown,
      0U);
  EXPECT_LE(judgement.uncertain, kListPoints * inflicted);
  std::cout << "  " << inflicted << " faults, " << judgement.points << " points, "
            << judgement.flashes << " made, " << judgement.uncertain << " uncertain\n";
}

// The axis has lost its place: nothing is made before a person has homed it.
TEST_F(BoardPoints, APowerCycleWaitsForAPerson) {
  OpenShop();
  Submit();
  ASSERT_TRUE(Eventually([&] { return Flashes().size() > 60; }, 60s));
  AtPanel("power off");
  std::this_thread::sleep_for(1s);
  const std::size_t made = Flashes().size();
  AtPanel("power on");
  (void)AwaitDone(8s, true);
  EXPECT_EQ(Flashes().size(), made) << "made before it was homed";
  std::string homed = "not begun";
  ASSERT_TRUE(Eventually(
      [&] {
        homed = Type({"teach", "home"});
        return homed.empty();
      },
      60s))
      << homed;
  ASSERT_TRUE(AwaitDone(240s, true)) << shown_;
  const Judgement judgement = Judge();
  EXPECT_EQ(
      judgement.doubled + judgement.stray + judgement.missing + judgement.made_unknown,
      0U);
  EXPECT_LE(judgement.uncertain, kListPoints);
  std::cout << "  " << judgement.points << " points, " << judgement.uncertain
            << " uncertain\n";
}

}  // namespace
}  // namespace intaglio
