// A job through the product's processes and a controller of isel: the virtual isel in a
// process of its own, whose record of its output is the judge.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <unistd.h>

#include <array>
#include <fstream>
#include <map>
#include <memory>
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

constexpr double kStepsPerMm = 80;  // of the supplied profile
using Steps = std::array<long, 3>;

class IselJob : public ::testing::Test {
 protected:
  IselJob() : folder_(test::FreshFolder()), tag_("isel" + std::to_string(getpid())) {
    controller_ = std::make_unique<Running>(
        fs::path(INTAGLIO_BIN_DIR).parent_path() / "tests/virtual-isel",
        std::vector<std::string>{"--line", (folder_ / "line").string(), "--record",
                                 (folder_ / "record.txt").string()},
        folder_ / "controller.log");
    Eventually([this] { return fs::exists(folder_ / "line"); }, 10s);
    fs::create_directory(socket_);
    fs::permissions(socket_, fs::perms::owner_all);
    WriteProfile();
    std::ofstream(folder_ / "job.textproto")
        << "name: \"knot\"\nmodels { file: \"" << INTAGLIO_SOURCE_DIR
        << "/deploy/jobs/sample.obj\" placement { fit_height_mm: 2.4 } }\n"
           "block { size_mm { x: 50 y: 50 z: 30 } }\nglass: \"N-BK7\"\n"
           "discretization { min_spacing_mm: 0.4 }\n"
           "laser { photosensor_feedback: false rate_hz: 50 }\n"
           "machine_file: \"shop/machine.textproto\"\n";
  }
  ~IselJob() override {
    if (shop_) {
      shop_->Signal(SIGTERM);
      shop_->WaitForEnd(20s);
    }
    std::error_code ignored;
    fs::remove_all(socket_, ignored);
  }

  void WriteProfile() const {
    std::ifstream in(INTAGLIO_SOURCE_DIR "/deploy/machines/isel.textproto");
    std::ofstream out(folder_ / "machine.textproto");
    for (std::string line; std::getline(in, line);) {
      if (line.starts_with("motion_line")) {
        line = "motion_line { protocol: \"isel\" device: \"" +
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
  std::vector<Steps> Flashes(bool* moved = nullptr) const {
    std::vector<Steps> flashes;
    std::ifstream record(folder_ / "record.txt");
    for (std::string line; std::getline(record, line);) {
      std::istringstream in(line);
      std::string kind;
      Steps at{};
      double on_us = 0;
      bool with_motion = false;
      if (!(in >> kind >> at[0] >> at[1] >> at[2] >> on_us >> with_motion)) continue;
      flashes.push_back(at);
      if (moved != nullptr) *moved = *moved || with_motion;
    }
    return flashes;
  }

  struct Judgement {
    std::size_t points = 0, flashes = 0, made = 0, doubled = 0, stray = 0, uncertain = 0;
    bool moved = false;
  };
  Judgement Judge() const;

  fs::path folder_;
  std::string tag_, shown_;
  // Its path is short: that of a socket has 107 bytes.
  std::string socket_ = "/tmp/isel" + std::to_string(getpid());
  std::unique_ptr<Running> controller_, shop_;
};

// In x and y the axes are where the points are. In z glass refracts: points of one height
// have one height of the axis, so each flash is compared with those of its own x and y,
// the deepest first in both.
IselJob::Judgement IselJob::Judge() const {
  Judgement judgement;
  fs::path job;
  for (const auto& entry : fs::directory_iterator(folder_ / "shop/jobs")) {
    if (entry.path().filename().string().starts_with("1-")) job = entry.path();
  }
  const auto path = formats::ReadPly(job / "path.ply");
  const auto journal = formats::ReadJournal(job / "journal.bin");
  EXPECT_TRUE(path && journal);
  if (!path || !journal) return judgement;
  using Column = std::pair<long, long>;
  std::map<Column, std::size_t> points;
  std::map<Column, std::map<long, int>> flashes;
  for (const Vec3& point : path->points_mm) {
    ++points[{std::lround(point.x() * kStepsPerMm),
              std::lround(point.y() * kStepsPerMm)}];
  }
  for (const Steps& flash : Flashes(&judgement.moved)) {
    ++judgement.flashes;
    const Column column{flash[0], flash[1]};
    judgement.stray += points.count(column) == 0;
    judgement.doubled += ++flashes[column][flash[2]] > 1;
  }
  for (const auto& [column, heights] : flashes) judgement.made += heights.size();
  judgement.points = path->points_mm.size();
  std::vector<formats::PointOutcome> last(judgement.points, formats::PointOutcome::kNone);
  for (const formats::JournalRecord& one : journal->records) {
    if (one.kind == formats::JournalKind::kOutcome) last.at(one.point) = one.outcome;
  }
  for (const auto outcome : last)
    judgement.uncertain += outcome == formats::PointOutcome::kUncertain;
  return judgement;
}

TEST_F(IselJob, EveryPointIsMadeOnceAtItsStepAndAtRest) {
  OpenShop();
  Submit();
  ASSERT_TRUE(AwaitDone(240s, false)) << shown_;
  const Judgement judgement = Judge();
  EXPECT_GT(judgement.points, 50U);
  EXPECT_EQ(judgement.made, judgement.points);
  EXPECT_EQ(judgement.flashes, judgement.points);
  EXPECT_EQ(judgement.doubled + judgement.stray + judgement.uncertain, 0U);
  EXPECT_FALSE(judgement.moved);
  std::cout << "  " << judgement.points << " points\n";
}

// A controller that homes is mute for longer than a status is believed: two seconds here.
// On a busy computer the jog, or the home, is let go before: then once more.
TEST_F(IselJob, HomeByHandLastsAsLongAsTheControllerTakes) {
  OpenShop();
  std::string homed = "not begun", place;
  const auto goes_home = [&] {
    (void)Type({"teach", "move", "50", "0", "0", "--speed", "30"});
    place = Type({"teach", "status"});
    if (place.find("x         50.0000 mm") == std::string::npos) return false;
    homed = Type({"teach", "home"});
    return homed.empty();
  };
  ASSERT_TRUE(Eventually(goes_home, 90s)) << homed << place;
  EXPECT_THAT(Type({"teach", "status"}), ::testing::HasSubstr("x          0.0000 mm"));
}

TEST_F(IselJob, KillsOfTheBridgeDoubleNoPoint) {
  OpenShop();
  Submit();
  std::size_t killed = 0;
  for (int i = 0; i < 3; ++i) {
    const std::size_t before = Flashes().size();
    if (!Eventually([&] { return Flashes().size() > before + 7; }, 30s)) break;
    for (const pid_t process :
         testing::ProcessesWith({"/intaglio-motion-bridge", tag_})) {
      killed += kill(process, SIGKILL) == 0;
    }
    (void)AwaitDone(3s, true);
  }
  ASSERT_TRUE(AwaitDone(240s, true)) << shown_;
  const Judgement judgement = Judge();
  EXPECT_GT(killed, 0U);
  EXPECT_EQ(judgement.doubled + judgement.stray, 0U);
  // They are of the points that the profile allows open when the bridge dies.
  EXPECT_LE(judgement.uncertain, 4U * killed);
  EXPECT_GE(judgement.made + judgement.uncertain, judgement.points);
  EXPECT_FALSE(judgement.moved);
  std::cout << "  " << killed << " kills, " << judgement.points << " points, "
            << judgement.made << " made, " << judgement.uncertain << " uncertain\n";
}

}  // namespace
}  // namespace intaglio
