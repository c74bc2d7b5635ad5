// Jobs through LinuxCNC itself, by the product's processes: every pulse is where HAL's
// sampler saw the axes, and a kill of any process doubles and loses none.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <memory>
#include <sstream>

#include "engrave/formats/point_file.h"
#include "tests/integration/point_difference.h"
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
    machine_ = std::make_unique<linuxcnc::HalMachine>(folder_ / "hal", "", AxesFile());
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
              "--folder", folder_ / "shop", "--materials", folder_ / "materials.db",
              "--block", "20", "20", "20", "--block-glass", "N-BK7"}),
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
  /// The supplied one, and two more instruments of HAL: for how many seconds the watchdog
  /// was tripped, and for how many of them the laser's bit was on.
  std::filesystem::path AxesFile() const {
    const auto file = folder_ / "axes.hal";
    std::ofstream(file)
        << test::ContentOf(INTAGLIO_SOURCE_DIR "/deploy/linuxcnc/simulated.hal")
        << "loadrt lut5 names=silent,silent-lit\n"
           "loadrt conv_bit_float names=silent-bit,silent-lit-bit\n"
           "loadrt integ names=silent-time,silent-lit-time\n"
           "net host-alive => silent.in-0 silent-lit.in-0\n"
           "net laser-out => silent-lit.in-1\n"
           "setp silent.function 1\n"      // not in-0
           "setp silent-lit.function 4\n"  // in-1 and not in-0
           "net silent-on silent.out => silent-bit.in\n"
           "net silent-lit-on silent-lit.out => silent-lit-bit.in\n"
           "net silent-number silent-bit.out => silent-time.in\n"
           "net silent-lit-number silent-lit-bit.out => silent-lit-time.in\n"
           "addf silent servo\naddf silent-lit servo\n"
           "addf silent-bit servo\naddf silent-lit-bit servo\n"
           "addf silent-time servo\naddf silent-lit-time servo\n";
    return file;
  }
  std::vector<std::string> With(std::vector<std::string> words) const {
    words.insert(words.end(), {"--domain", "73", "--tag", tag_});
    return words;
  }
  /// A job that the virtual engraver takes, too; by default the supplied one.
  std::unique_ptr<Running> Submit(const std::vector<std::string>& options,
                                  const std::string& job = "sample") const {
    std::vector<std::string> words = {
        "submit", job, "--machine", folder_ / "machine.textproto", "--arm", "--watch"};
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
  /// In any order: a busy computer leaves points of a run to the next one.
  void ExpectEveryPointOnce() const {
    const auto pulses = Pulses();
    PointList made_mm;
    for (const Pulse& pulse : pulses) made_mm.push_back(pulse.place_mm);
    EXPECT_EQ(testing::PointDifference(Places(), made_mm, 0.005), "");
    const auto not_later = [](const Pulse& a, const Pulse& b) {
      return b.tick <= a.tick;
    };
    EXPECT_TRUE(std::ranges::adjacent_find(pulses, not_later) == pulses.end());
    std::cout << fmt::format("  {} pulses\n", pulses.size());
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

// INTAGLIO_MESHES: a folder with bunny.obj (tests/data/README.md); with INTAGLIO_LONG=1
// some 5000 points of it, else some hundreds.
TEST_F(LinuxcncJob, PutsEveryPulseOfABunnyAtItsPoint) {
  const char* meshes = std::getenv("INTAGLIO_MESHES");
  if (meshes == nullptr) GTEST_SKIP() << "INTAGLIO_MESHES names no folder";
  const bool all = std::getenv("INTAGLIO_LONG") != nullptr;
  const auto file = folder_ / "bunny.textproto";
  std::ofstream(file) << fmt::format(
      "name: \"bunny\"\nmodels {{ file: \"{}/bunny.obj\" placement {{ "
      "rotate_deg {{ x: 90 }} fit_height_mm: 13 }} }}\n"
      "block {{ size_mm {{ x: 20 y: 20 z: 20 }} }}\nglass: \"N-BK7\"\n"
      "discretization {{ min_spacing_mm: {} }}\nlaser {{ rate_hz: {} }}\n"
      "machine_file: \"machine.textproto\"\n",
      meshes, all ? 0.265 : 0.9, all ? 200 : 100);
  const auto job = Submit({}, file.string());
  const auto ended = job->WaitForEnd(all ? 280s : 150s);
  ASSERT_EQ(ended.exit_code, 0) << ended.output;
  EXPECT_GT(Pulses().size(), all ? 5000u : 200u);
  ExpectEveryPointOnce();
}

TEST_F(LinuxcncJob, HasAProfileThatAgreesWithItsHal) {
  Running check(Program("intaglio"),
                {"machine", "check", folder_ / "machine.textproto", "--json"},
                folder_ / "check.json");
  const auto ended = check.WaitForEnd(60s);
  EXPECT_EQ(ended.exit_code, 0) << ended.output;
  EXPECT_NE(ended.output.find("\"good\""), std::string::npos) << ended.output;
}

class LinuxcncKill : public LinuxcncJob,
                     public ::testing::WithParamInterface<const char*> {};

TEST_P(LinuxcncKill, TurnsTheLaserOffAndDoublesNothing) {
  const auto job = Submit(kSmall);
  ASSERT_TRUE(Eventually([&] { return Pulses().size() > 60; }, 60s)) << job->Output();
  const auto processes = testing::ProcessesWith({GetParam(), tag_});
  ASSERT_EQ(processes.size(), 1u);
  const double silent_before_s = machine_->ValueOf("silent-time.out"),
               lit_before_s = machine_->ValueOf("silent-lit-time.out");
  kill(processes.front(), SIGKILL);
  const auto ended = job->WaitForEnd(150s);
  ASSERT_EQ(ended.exit_code, 0) << ended.output << shop_->Output();
  ExpectEveryPointOnce();
  // By HAL's own periods. Rows of a killed bridge are played for 100 ms, half as long as
  // its watchdog waits: so not a period is lit once it has tripped, but for the one in
  // which the laser is switched off after it.
  const double silent_s = machine_->ValueOf("silent-time.out") - silent_before_s,
               lit_s = machine_->ValueOf("silent-lit-time.out") - lit_before_s;
  // On a computer that is too busy the others' bridge may be silent, too.
  if (std::string(GetParam()) == "intaglio-motion-bridge") {
    EXPECT_GT(silent_s, 0);
  }
  EXPECT_LE(lit_s, 0.1);
  std::cout << fmt::format("  silent for {:.3f} s, lit for {:.3f} s of them\n", silent_s,
                           lit_s);
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
