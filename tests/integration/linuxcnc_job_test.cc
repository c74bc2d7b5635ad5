// Jobs through LinuxCNC itself, by the product's processes: every pulse is where HAL's
// sampler saw the axes, and a kill of any process doubles and loses none.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <memory>
#include <sstream>

#include "engrave/formats/point_file.h"
#include "tests/integration/run_program.h"
#include "tests/services/drivers/linuxcnc/hal_machine.h"
#include "tests/test_folder.h"

namespace intaglio {
namespace {

using namespace std::chrono_literals;
using testing::Eventually;
using testing::Program;
using testing::Running;

struct Pulse {
  std::uint64_t tick = 0;
  Vec3 place_mm = Vec3::Zero();
};

class LinuxcncJob : public ::testing::Test {
 protected:
  void SetUp() override {
    if (const auto why = linuxcnc::EnterNamespace(); !why.empty()) GTEST_SKIP() << why;
    folder_ = test::FreshFolder();
    tag_ = fmt::format("linuxcnc-{}", getpid());
    // The path of a socket is short, and its folder this user's alone.
    std::string folder = "/tmp/intaglio-XXXXXX";
    ASSERT_NE(mkdtemp(folder.data()), nullptr);
    socket_ = folder;
    std::filesystem::create_directories(folder_ / "hal");
    machine_ = std::make_unique<linuxcnc::HalMachine>(folder_ / "hal");
    std::string profile =
        test::ContentOf(INTAGLIO_SOURCE_DIR "/deploy/machines/linuxcnc.textproto");
    const std::string supplied = "/run/intaglio-linuxcnc";
    profile.replace(profile.find(supplied), supplied.size(), machine_->folder().string());
    const std::string laser = "protocol: \"motion-output\"";
    profile.replace(profile.find(laser), laser.size(),
                    laser + fmt::format(" device: \"unix:{}/laser\"", socket_.string()));
    std::ofstream(folder_ / "machine.textproto") << profile;
    shop_ = std::make_unique<Running>(
        Program("intaglio"),
        With({"up", "--real-machine", "--machine", folder_ / "machine.textproto",
              "--folder", folder_ / "shop", "--materials", folder_ / "materials.db"}),
        folder_ / "shop.log");
    ASSERT_TRUE(Eventually(
        [&] { return shop_->Output().find("the shop is open") != std::string::npos; },
        40s))
        << shop_->Output();
  }
  void TearDown() override {
    if (shop_ == nullptr) return;
    shop_->Signal(SIGTERM);
    shop_->WaitForEnd(20s);
    shop_.reset();
    machine_.reset();
    std::filesystem::remove_all(socket_);
  }
  std::vector<std::string> With(std::vector<std::string> words) const {
    words.insert(words.end(), {"--domain", "73", "--tag", tag_});
    return words;
  }
  /// The supplied job, which the virtual engraver takes, too.
  std::unique_ptr<Running> Submit(const std::vector<std::string>& options) const {
    std::vector<std::string> words = {"submit",    "sample",
                                      "--machine", folder_ / "machine.textproto",
                                      "--arm",     "--watch"};
    words.insert(words.end(), options.begin(), options.end());
    return std::make_unique<Running>(Program("intaglio"), With(words),
                                     folder_ / "submit.log");
  }
  std::vector<Pulse> Pulses() const {
    std::ifstream in(machine_->folder() / "pulses");
    std::vector<Pulse> all;
    for (Pulse p; in >> p.tick >> p.place_mm.x() >> p.place_mm.y() >> p.place_mm.z();)
      all.push_back(p);
    return all;
  }
  /// Where the axes have to be for the points of the job, in its order.
  PointList Places() const {
    PointList places;
    for (const auto& job :
         std::filesystem::directory_iterator(folder_ / "shop" / "jobs")) {
      const auto cloud = formats::ReadPly(job.path() / "path.ply");
      if (!cloud) continue;
      for (const Vec3& p : cloud->points_mm)
        places.emplace_back(p.x(), p.y(), kTop_mm - (kTop_mm - p.z()) * kStagePerGlass);
    }
    return places;
  }
  void ExpectEveryPointOnce() const {
    const auto pulses = Pulses();
    const PointList places = Places();
    ASSERT_EQ(pulses.size(), places.size());
    double worst_mm = 0;
    for (std::size_t i = 0; i < pulses.size(); ++i) {
      worst_mm =
          std::max(worst_mm, (pulses[i].place_mm - places[i]).cwiseAbs().maxCoeff());
      if (i > 0) {
        EXPECT_GT(pulses[i].tick, pulses[i - 1].tick);
      }
    }
    EXPECT_LT(worst_mm, 0.005);
    std::cout << fmt::format("  {} pulses, the farthest {:.3f} um from its point\n",
                             pulses.size(), worst_mm * 1e3);
  }

  // The job's block, 20 mm high, of N-BK7 (1.51947 at 532 nm), below a lens with the
  // numerical aperture 0.2: the way of the stage for one of the focus is that of the
  // marginal ray's slopes.
  static constexpr double kTop_mm = 20;
  const double kStagePerGlass =
      (0.2 / 1.51947 / std::sqrt(1 - 0.04 / (1.51947 * 1.51947))) /
      (0.2 / std::sqrt(1 - 0.04));

  std::filesystem::path folder_, socket_;
  std::string tag_;
  std::unique_ptr<linuxcnc::HalMachine> machine_;
  std::unique_ptr<Running> shop_;
};

const std::vector<std::string> kSmall = {
    "--block", "20", "20", "20", "--size", "6", "--spacing", "0.5", "--rate", "100"};

TEST_F(LinuxcncJob, PutsEveryPulseAtItsPoint) {
  const auto job = Submit(kSmall);
  const auto ended = job->WaitForEnd(150s);
  ASSERT_EQ(ended.exit_code, 0) << ended.output;
  EXPECT_GT(Pulses().size(), 100u);
  ExpectEveryPointOnce();
}

class LinuxcncKill : public LinuxcncJob,
                     public ::testing::WithParamInterface<const char*> {};

TEST_P(LinuxcncKill, TurnsTheLaserOffAndDoublesNothing) {
  const auto job = Submit(kSmall);
  ASSERT_TRUE(Eventually([&] { return Pulses().size() > 60; }, 60s)) << job->Output();
  const auto processes = testing::ProcessesWith({GetParam(), tag_});
  ASSERT_EQ(processes.size(), 1u);
  const std::size_t before = Pulses().size();
  kill(processes.front(), SIGKILL);
  // The watchdog of 200 ms, and 100 ms; the process is back later, or was not needed.
  const std::size_t allowed = before + 100 * 3 / 10 + 1;
  if (std::string(GetParam()) == "intaglio-motion-bridge") {
    std::this_thread::sleep_for(300ms);
    EXPECT_LE(Pulses().size(), allowed) << "100 pulses a second, for 0.3 s";
  }
  const auto ended = job->WaitForEnd(150s);
  ASSERT_EQ(ended.exit_code, 0) << ended.output << shop_->Output();
  ExpectEveryPointOnce();
}

INSTANTIATE_TEST_SUITE_P(Of, LinuxcncKill,
                         ::testing::Values("intaglio-motion-bridge",
                                           "intaglio-synchronizer",
                                           "intaglio-job-service"),
                         [](const auto& program) {
                           std::string name = program.param;
                           std::replace(name.begin(), name.end(), '-', '_');
                           return name;
                         });

}  // namespace
}  // namespace intaglio
