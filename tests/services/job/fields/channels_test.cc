#include "services/job/fields/channels.h"

#include <gmock/gmock.h>

#include "engrave/core/check.h"
#include "services/job/checks/job_check.h"
#include "services/job/convert/job_defaults.h"
#include "services/job/models/model_sources.h"
#include "tests/services/job/test_job.h"

namespace intaglio {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::UnorderedElementsAre;

constexpr double kTravelRatio = 0.65;

void Set(Vector3& v, double x, double y, double z) { v.set_x(x), v.set_y(y), v.set_z(z); }

/// One model in all four channels, one in the second, one in the third and fourth.
JobSpec FourBlocks() {
  JobSpec job = GoodJob();
  while (job.models_size() < 3) *job.add_models() = job.models(0);
  for (const std::uint32_t channel : {1, 2, 3, 4})
    job.mutable_laser()->add_channels(channel);
  job.mutable_models(1)->add_channels(2);
  job.mutable_models(2)->add_channels(4);
  job.mutable_models(2)->add_channels(3);
  return job;
}

JobSpec WithBlock(JobSpec job, std::uint32_t channel, double x, double y, double z) {
  ChannelBlock& own = *job.add_channel_blocks();
  own.set_channel(channel);
  Set(*own.mutable_size_mm(), x, y, z);
  return job;
}

std::vector<std::string> Complaints(const JobSpec& job) {
  std::vector<std::string> sent;
  for (const Error& error : CheckAll(job, GoodMachine(), kTravelRatio)) {
    sent.push_back(error.message);
  }
  return sent;
}

TEST(JobChannels, AModelIsMadeInThoseItNamesOrInAll) {
  const JobSpec job = WithDefaults(FourBlocks(), GoodMachine());
  EXPECT_THAT(ChannelsOfModels(job), ElementsAre(15, 2, 12));
  EXPECT_THAT(job.models(0).channels(), ElementsAre(1, 2, 3, 4)) << "filled in";
  EXPECT_THAT(ChannelsOfModels(WithDefaults(GoodJob(), GoodMachine())), ElementsAre(1));
  JobSpec without = job;
  without.clear_models();
  EXPECT_THAT(ChannelsOfModels(without), ElementsAre(15));
}

TEST(JobChannels, APointIsMadeInThoseOfItsModel) {
  const JobSpec job = WithDefaults(FourBlocks(), GoodMachine());
  const std::vector<std::uint32_t> source = {2, 0, 1, 1};
  EXPECT_THAT(ChannelsOfPoints(job, source).value(), ElementsAre(12, 15, 2, 2));
  const auto unknown = ChannelsOfPoints(job, std::vector<std::uint32_t>{0, 3});
  ASSERT_FALSE(unknown.has_value());
  EXPECT_THAT(unknown.error().message, HasSubstr("point 1 is of model 3"));
}

TEST(JobChannels, TheBlockOfAModelIsWhatItsBlocksHaveInCommon) {
  const JobSpec job = WithDefaults(
      WithBlock(WithBlock(FourBlocks(), 3, 40, 50, 30), 4, 50, 20, 30), GoodMachine());
  const auto size = [&](int model) { return BlockOf(job, job.models(model)).size_mm(); };
  EXPECT_EQ(size(0).x(), 40);
  EXPECT_EQ(size(0).y(), 20);
  EXPECT_EQ(size(1).x(), 50);
  EXPECT_EQ(size(2).x(), 40);
  EXPECT_EQ(size(2).y(), 20);
  EXPECT_EQ(size(2).z(), 30);
}

TEST(JobChannels, ThinningAndBoundsKnowThem) {
  const auto one = CloudOptionsOf(WithDefaults(GoodJob(), GoodMachine()));
  EXPECT_THAT(one.thinning.channels_of_source, IsEmpty());
  EXPECT_THAT(one.permitted_of_source_mm, IsEmpty());
  const JobSpec job = WithBlock(FourBlocks(), 2, 40, 50, 30);
  const auto options = CloudOptionsOf(WithDefaults(job, GoodMachine()));
  EXPECT_THAT(options.thinning.channels_of_source, ElementsAre(15, 2, 12));
  ASSERT_EQ(options.permitted_of_source_mm.size(), 3u);
  EXPECT_EQ(options.permitted_of_source_mm[0].max_mm.x(), 37);
  EXPECT_EQ(options.permitted_of_source_mm[2].max_mm.x(), 47);
}

TEST(JobChannels, GoodOnesAreGood) {
  EXPECT_THAT(Complaints(FourBlocks()), IsEmpty());
  EXPECT_THAT(Complaints(WithBlock(FourBlocks(), 4, 40, 45, 30)), IsEmpty());
}

TEST(JobChannels, MistakesAreReportedWithTheirRemedies) {
  JobSpec job = FourBlocks();
  job.mutable_laser()->clear_channels();
  job.mutable_laser()->add_channels(2);
  job.mutable_laser()->add_channels(4);
  job.mutable_models(1)->add_channels(2);
  EXPECT_THAT(
      Complaints(job),
      UnorderedElementsAre("models[1].channels[1]: 2 occurs twice",
                           "models[2].channels[1]: 3 is not among laser.channels, 2 4; "
                           "add it there or remove it here"));
  job = WithBlock(FourBlocks(), 3, 60, 5, 25);
  job.mutable_laser()->mutable_channels()->RemoveLast();
  job.mutable_models(2)->set_channels(0, 3);
  job.mutable_models(2)->mutable_channels()->RemoveLast();
  job = WithBlock(WithBlock(job, 3, 40, 40, 30), 4, 40, 40, 30);
  job.add_channel_blocks()->set_channel(1);
  EXPECT_THAT(Complaints(job),
              UnorderedElementsAre(
                  "channel_blocks[0].size_mm.x: 60 is more than that of the block, 50; "
                  "give the size of the largest block as block.size_mm",
                  "channel_blocks[0].size_mm.y: 5 leaves no space between the margins; "
                  "reduce block.margin_mm, 3",
                  "channel_blocks[0].size_mm.z: 25 is not the height of the block, 30; "
                  "all channels have the same focus: use blocks of one height",
                  "channel_blocks[1].channel: 3 occurs twice",
                  "channel_blocks[2].channel: 4 is not among laser.channels, 1 2 3; add "
                  "it there or remove it here",
                  "channel_blocks[3].size_mm: is missing; give the block's size, 1..1000 "
                  "mm in each axis"));
}

}  // namespace
}  // namespace intaglio
