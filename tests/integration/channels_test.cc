// Four blocks at once: the example as a user types it, and the glass of each channel
// counted here again, with nothing of the product's own proof.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <algorithm>
#include <fstream>

#include "engrave/formats/glass_record.h"
#include "engrave/formats/point_file.h"
#include "tests/integration/run_job.h"

namespace intaglio {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using testing::Ended;
using testing::Eventually;
using ::testing::HasSubstr;
using testing::ProcessesWith;
using testing::Program;
using testing::Running;

constexpr auto kBound = 90s;
constexpr std::uint32_t kChannels = 4;
// The machine's tolerance is 30 um.
constexpr double kNearMm = 0.03;

class FourBlocks : public testing::RunJob {
 protected:
  static fs::path Example() {
    return fs::path(INTAGLIO_SOURCE_DIR) / "deploy/jobs/four_blocks.textproto";
  }
  std::vector<std::string> Arguments(std::vector<std::string> more,
                                     const fs::path& job = Example()) const {
    return RunJob::Arguments(std::move(more), job);
  }

  /// The first model is in all blocks, the others in one each. Every crack of a block is
  /// at a point of it, and every point has one.
  void ExpectEachBlockHoldsItsOwn() const {
    const auto glass = formats::ReadPly(folder_ / "out/glass.ply");
    const auto path = formats::ReadPly(folder_ / "out/path.ply");
    ASSERT_TRUE(glass && path);
    const auto& source = *path->Find<std::uint32_t>("source");
    const auto& channel = *glass->Find<std::uint8_t>("channel");
    for (std::uint32_t block = 0; block < kChannels; ++block) {
      PointList planned_mm, cracks_mm;
      bool named = false;
      for (std::size_t i = 0; i < source.size(); ++i) {
        if (source[i] != 0 && source[i] != block + 1) continue;
        named = named || source[i] != 0;
        planned_mm.push_back(path->points_mm[i]);
      }
      for (std::size_t i = 0; i < channel.size(); ++i) {
        if (channel[i] == block) cracks_mm.push_back(glass->points_mm[i]);
      }
      EXPECT_TRUE(named);
      ASSERT_EQ(cracks_mm.size(), planned_mm.size()) << "channel " << block + 1;
      std::vector<int> cracks_of(planned_mm.size(), 0);
      for (const Vec3& crack : cracks_mm) {
        const auto at =
            std::find_if(planned_mm.begin(), planned_mm.end(),
                         [&](const Vec3& p) { return (p - crack).norm() < kNearMm; });
        ASSERT_NE(at, planned_mm.end()) << "a stray crack in channel " << block + 1;
        ++cracks_of[static_cast<std::size_t>(at - planned_mm.begin())];
      }
      EXPECT_EQ(std::count(cracks_of.begin(), cracks_of.end(), 1),
                static_cast<std::ptrdiff_t>(cracks_of.size()))
          << "channel " << block + 1;
    }
  }
};

TEST_F(FourBlocks, HoldTheSameKnotAndANameEach) {
  Running run(Program("intaglio"), Arguments({"--lockstep"}), folder_ / "output.txt");
  const Ended ended = run.WaitForEnd(kBound);
  ASSERT_TRUE(ended.in_time);
  ASSERT_EQ(ended.exit_code, 0) << ended.output;
  const JobReport report = Report();
  EXPECT_TRUE(report.verdict().good());
  EXPECT_EQ(report.shadow_violations(), 0u);
  EXPECT_GE(report.measured_spacing_mm(), 0.25);
  // A run for each set of shutters; one more for each time a busy host paused it.
  EXPECT_GE(report.engrave().run_count(), 5u);
  EXPECT_EQ(report.sort().shutter_change_count(), 4u);
  ASSERT_EQ(report.channels_size(), static_cast<int>(kChannels));
  for (const ChannelCounts& channel : report.channels()) {
    EXPECT_GT(channel.planned(), 500u);
    EXPECT_EQ(channel.made(), channel.planned());
    EXPECT_THAT(ended.output, HasSubstr("channel " + std::to_string(channel.channel())));
  }
  ExpectEachBlockHoldsItsOwn();
}

// What two blocks share lies where both have glass, and a name in the middle of its own.
TEST_F(FourBlocks, OfDifferentSizesEachHasItsPointsWithinItself) {
  const fs::path job = folder_ / "job.textproto";
  {
    std::ifstream in(Example());
    std::ofstream out(job);
    for (std::string line; std::getline(in, line);) {
      for (const char* name : {"sample.obj", "../machines"}) {
        const std::size_t at = line.find(name);
        if (at != std::string::npos)
          line.insert(at, Example().parent_path().string() + "/");
      }
      out << line << '\n';
    }
    out << "channel_blocks { channel: 2 size_mm { x: 30 y: 36 z: 40 } }\n"
           "channel_blocks { channel: 4 size_mm { x: 34 y: 26 z: 40 } }\n";
  }
  Running run(Program("intaglio"), Arguments({"--lockstep", "--spacing", "0.5"}, job),
              folder_ / "output.txt");
  const Ended ended = run.WaitForEnd(kBound);
  ASSERT_TRUE(ended.in_time);
  ASSERT_EQ(ended.exit_code, 0) << ended.output;
  ExpectEachBlockHoldsItsOwn();
  const auto glass = formats::ReadPly(folder_ / "out/glass.ply");
  const auto path = formats::ReadPly(folder_ / "out/path.ply");
  const auto& channel = *glass->Find<std::uint8_t>("channel");
  const Vec3 sizes_mm[kChannels] = {
      {40, 40, 40}, {30, 36, 40}, {40, 40, 40}, {34, 26, 40}};
  for (std::size_t i = 0; i < channel.size(); ++i) {
    const Box3 block{Vec3(Vec3::Zero()), sizes_mm[channel[i]]};
    ASSERT_TRUE(block.Contains(glass->points_mm[i])) << "channel " << channel[i] + 1;
  }
  // The source of each model: the knot, then the names.
  const auto& source = *path->Find<std::uint32_t>("source");
  for (std::uint32_t model = 0; model <= kChannels; ++model) {
    Box3 bounds;
    for (std::size_t i = 0; i < source.size(); ++i) {
      if (source[i] == model) bounds.Extend(path->points_mm[i]);
    }
    const Vec3 expected_mm =
        model == 0 ? Vec3(30, 26, 0) / 2 : Vec3(sizes_mm[model - 1] / 2);
    const Vec3 middle_mm = bounds.center_mm();
    EXPECT_NEAR(middle_mm.x(), expected_mm.x(), 0.6) << "model " << model;
    EXPECT_NEAR(middle_mm.y(), expected_mm.y(), 0.6) << "model " << model;
  }
}

// The one who has the masks in its head dies; the next one has them from the disk.
TEST_F(FourBlocks, TakenUpByAnotherSynchronizerNoneGetsWhatIsNotItsOwn) {
  Running run(Program("intaglio"),
              Arguments({"--speed", "4", "--warm-up", "0", "--spacing", "0.8"}),
              folder_ / "output.txt");
  for (const std::size_t cracks : {30U, 250U}) {
    ASSERT_TRUE(Eventually(
        [&] {
          const auto glass = formats::ReadGlassRecord(folder_ / "out/session/glass.rec");
          return glass && glass->cracks.size() >= cracks;
        },
        40s))
        << run.Output();
    const auto victims =
        ProcessesWith({"intaglio-synchronizer", "run-" + std::to_string(run.pid())});
    ASSERT_EQ(victims.size(), 1u);
    kill(victims[0], SIGKILL);
  }
  const Ended ended = run.WaitForEnd(kBound);
  ASSERT_TRUE(ended.in_time) << ended.output;
  EXPECT_EQ(ended.exit_code, 0) << ended.output;
  EXPECT_THAT(ended.output, HasSubstr("synchronizer has ended unexpectedly"));
  EXPECT_TRUE(Report().verdict().good());
  ExpectEachBlockHoldsItsOwn();
}

}  // namespace
}  // namespace intaglio
