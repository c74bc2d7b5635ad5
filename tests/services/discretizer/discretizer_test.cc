// The program as the job service and the sorter see it.

#include <gtest/gtest.h>

#include <cmath>

#include "services/platform/bus/error_code.h"
#include "services/platform/host/stage/flow.h"
#include "tests/services/discretizer/box_model.h"
#include "tests/services/platform/host/stage/stage_shop.h"

namespace intaglio {
namespace {

using namespace std::chrono_literals;
using test::BoxStl;
using test::Eventually;
using test::FeedModels;
using test::FrozenJobOf;
using test::StageShop;

constexpr double kSide = 10, kBlock = 30, kSpacing = 0.5;

/// A cube in the middle of a block, sections.
JobSpec CubeJob(double spacing_mm = kSpacing) {
  JobSpec spec;
  spec.add_models()->set_file("/nowhere/cube.stl");
  auto& size = *spec.mutable_block()->mutable_size_mm();
  size.set_x(kBlock), size.set_y(kBlock), size.set_z(kBlock);
  spec.mutable_discretization()->set_min_spacing_mm(spacing_mm);
  spec.mutable_discretization()->mutable_sections();
  return spec;
}

class DiscretizerTest : public testing::Test {
 protected:
  DiscretizerTest() { EXPECT_TRUE(shop.AwaitHealth(intaglio_HEALTH_READY)); }
  /// Plays the sorter until the cloud is whole.
  Result<PointCloud> Consume() {
    Result<bool> taken = false;
    Eventually([&] { return taken = intake.Poll(), !taken || *taken; }, 20s);
    if (!taken) return tl::unexpected(taken.error());
    if (!*taken) return Fail(ErrorCode::kTimedOut, "the cloud does not come");
    return intake.TakeContent();
  }

  StageShop shop{"intaglio-discretizer", intaglio_STAGE_DISCRETIZE, bus::kDiscretizeTask};
  host::PointIntake intake{shop.bus(), "sorter", bus::kPointBatch};
};

TEST_F(DiscretizerTest, MakesThePointsOfACube) {
  ASSERT_TRUE(intake.Open("cube", 1));
  shop.Give(FrozenJobOf("cube", CubeJob()), 1, "sorter");
  ASSERT_TRUE(shop.AwaitHealth(intaglio_HEALTH_BUSY));
  ASSERT_TRUE(FeedModels(shop.bus(), "cube", 1, {BoxStl(kSide, kSide, kSide)}));
  const auto cloud = Consume();
  ASSERT_TRUE(cloud) << cloud.error().message;

  // On the walls of the cube in the block's middle. The file's numbers are whole, so only
  // the rounding of doubles is left.
  for (const Vec3& p : cloud->points_mm) {
    const Vec3 from_middle = p - Vec3::Constant(kBlock / 2);
    EXPECT_NEAR(from_middle.cwiseAbs().maxCoeff(), kSide / 2, 1e-9);
  }
  // 20 or so planes of 80 points, and two faces of 400 that no plane cuts; merging
  // vertices may remove a few at the edges.
  EXPECT_GT(cloud->size(), 2000u);
  EXPECT_LT(cloud->size(), 2500u);
  for (std::size_t i = 0; i < cloud->size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      ASSERT_GE((cloud->points_mm[i] - cloud->points_mm[j]).norm(), kSpacing - 1e-12);
    }
  }

  const auto end = shop.AwaitEnd("cube", 1);
  ASSERT_TRUE(end);
  EXPECT_EQ(end->state, intaglio_TASK_DONE) << end->message;
  EXPECT_EQ(end->done_count, cloud->size());
  const DiscretizeOutcome& outcome = end->outcome.discretize();
  EXPECT_EQ(outcome.point_count(), cloud->size());
  EXPECT_EQ(outcome.candidate_count(), cloud->size() + outcome.thinned_count());
  ASSERT_EQ(outcome.models_size(), 1);
  EXPECT_EQ(outcome.models(0).triangle_count(), 12u);
  EXPECT_EQ(outcome.models(0).vertex_count(), 8u);
  EXPECT_EQ(outcome.models(0).open_edge_count(), 0u);
  EXPECT_DOUBLE_EQ(outcome.models(0).size_x_mm(), kSide);
  EXPECT_GT(end->outcome.elapsed_s(), 0);
  EXPECT_TRUE(shop.AwaitHealth(intaglio_HEALTH_READY));
}

TEST_F(DiscretizerTest, GivesTheSameBitsTwice) {
  PointCloud clouds[2];
  for (std::uint32_t attempt = 0; attempt < 2; ++attempt) {
    ASSERT_TRUE(intake.Open("twice", attempt));
    shop.Give(FrozenJobOf("twice", CubeJob(0.1)), attempt, "sorter");
    ASSERT_TRUE(FeedModels(shop.bus(), "twice", attempt, {BoxStl(7, 8, 9)}));
    clouds[attempt] = Consume().value();
  }
  EXPECT_GT(clouds[0].size(), 8192u) << "more than one batch";
  EXPECT_EQ(clouds[0].points_mm, clouds[1].points_mm);
}

// One worker for all of them: it asks for the models once.
TEST_F(DiscretizerTest, PartsTogetherAreTheCloudOfOneBitForBit) {
  const std::string box = BoxStl(17, 8, 19);
  ASSERT_TRUE(intake.Open("whole", 1));
  shop.Give(FrozenJobOf("whole", CubeJob(0.1)), 1, "sorter");
  ASSERT_TRUE(FeedModels(shop.bus(), "whole", 1, {box}));
  const auto whole = Consume();
  ASSERT_TRUE(whole) << whole.error().message;
  ASSERT_TRUE(shop.AwaitEnd("whole", 1));

  ASSERT_TRUE(intake.Open("parts", 1, 4));
  Result<bool> taken = false;
  std::uint64_t point_count = 0;
  for (const host::TaskPart part :
       {host::TaskPart{2, 4, 0}, {0, 4, 1}, {3, 4, 0}, {1, 4, 2}}) {
    ASSERT_TRUE(shop.AwaitHealth(intaglio_HEALTH_READY));
    shop.Give(FrozenJobOf("parts", CubeJob(0.1)), 1, "sorter", part);
    if (part.index == 2) {
      ASSERT_TRUE(FeedModels(shop.bus(), "parts", 1, {box}, part));
    }
    std::optional<test::TaskReport> end;
    ASSERT_TRUE(Eventually([&] {
      taken = intake.Poll();
      end = shop.Find("parts", part, intaglio_TASK_DONE);
      return end.has_value();
    }));
    EXPECT_EQ(end->part.count, 4u);
    EXPECT_EQ(end->done_count, end->outcome.discretize().point_count());
    point_count += end->done_count;
  }
  taken = intake.Poll();
  ASSERT_TRUE(taken && *taken);
  const PointCloud parts = intake.TakeContent();
  EXPECT_EQ(parts.points_mm, whole->points_mm);
  EXPECT_EQ(parts.source, whole->source);
  EXPECT_EQ(point_count, whole->size());
}

// After a revocation nothing of the job is kept, and the models are asked for again.
TEST_F(DiscretizerTest, AWithdrawnJobIsNotKept) {
  shop.Give(FrozenJobOf("gone", CubeJob(0.03)), 1, "", {0, 2, 0});
  ASSERT_TRUE(FeedModels(shop.bus(), "gone", 1, {BoxStl(20, 20, 20)}, {0, 2, 0}));
  shop.Revoke("gone", 1, {0, 2, 0});
  ASSERT_TRUE(shop.AwaitEnd("gone", 1, {0, 2, 0}));
  ASSERT_TRUE(shop.AwaitHealth(intaglio_HEALTH_READY));
  shop.Give(FrozenJobOf("gone", CubeJob(1)), 1, "", {1, 2, 0});
  ASSERT_TRUE(FeedModels(shop.bus(), "gone", 1, {BoxStl(5, 5, 5)}, {1, 2, 0}));
  const auto end = shop.AwaitEnd("gone", 1, {1, 2, 0});
  ASSERT_TRUE(end);
  EXPECT_EQ(end->state, intaglio_TASK_DONE) << end->message;
}

TEST_F(DiscretizerTest, APartThatCannotBeIsRefused) {
  shop.Give(FrozenJobOf("parts", CubeJob()), 1, "", {4, 4, 0});
  const auto end = shop.AwaitEnd("parts", 1, {4, 4, 0});
  ASSERT_TRUE(end);
  EXPECT_EQ(end->error_code, bus::WireOf(ErrorCode::kUnreadable));
}

TEST_F(DiscretizerTest, ABadModelFailsItsTaskAndNotTheProcess) {
  shop.Give(FrozenJobOf("bad", CubeJob()), 1, "");
  ASSERT_TRUE(FeedModels(shop.bus(), "bad", 1, {"solid nothing\nfacet"}));
  const auto bad = shop.AwaitEnd("bad", 1);
  ASSERT_TRUE(bad);
  EXPECT_EQ(bad->state, intaglio_TASK_FAILED);
  EXPECT_NE(bad->error_code, intaglio_ERROR_NONE);
  EXPECT_NE(bad->message.find("/nowhere/cube.stl"), std::string::npos) << bad->message;

  // The next one is done; without a consumer nothing is streamed.
  ASSERT_TRUE(shop.AwaitHealth(intaglio_HEALTH_READY));
  shop.Give(FrozenJobOf("good", CubeJob()), 1, "");
  ASSERT_TRUE(FeedModels(shop.bus(), "good", 1, {BoxStl(5, 5, 5)}));
  const auto good = shop.AwaitEnd("good", 1);
  ASSERT_TRUE(good);
  EXPECT_EQ(good->state, intaglio_TASK_DONE) << good->message;
  EXPECT_GT(good->outcome.discretize().point_count(), 0u);
}

TEST_F(DiscretizerTest, PointsOutsideTheBlockAreAnErrorThatReportsHowMany) {
  shop.Give(FrozenJobOf("outside", CubeJob()), 1, "");
  ASSERT_TRUE(FeedModels(shop.bus(), "outside", 1, {BoxStl(40, 5, 5)}));
  const auto end = shop.AwaitEnd("outside", 1);
  ASSERT_TRUE(end);
  EXPECT_EQ(end->state, intaglio_TASK_FAILED);
  EXPECT_EQ(end->error_code, bus::WireOf(ErrorCode::kOutsideBlock)) << end->message;
}

TEST_F(DiscretizerTest, AnUnreadableTaskIsRefused) {
  shop.GiveBytes("garbled", 1, "\xff\xff\xff");
  const auto end = shop.AwaitEnd("garbled", 1);
  ASSERT_TRUE(end);
  EXPECT_EQ(end->error_code, bus::WireOf(ErrorCode::kUnreadable));
  EXPECT_TRUE(shop.AwaitHealth(intaglio_HEALTH_READY));
}

// Half a million points: it is still at it when the task is taken away.
TEST_F(DiscretizerTest, ARevokedTaskEndsPromptly) {
  shop.Give(FrozenJobOf("revoked", CubeJob(0.03)), 1, "");
  ASSERT_TRUE(FeedModels(shop.bus(), "revoked", 1, {BoxStl(20, 20, 20)}));
  shop.Revoke("revoked", 1);
  const auto start = std::chrono::steady_clock::now();
  const auto end = shop.AwaitEnd("revoked", 1);
  ASSERT_TRUE(end);
  EXPECT_EQ(end->state, intaglio_TASK_FAILED);
  EXPECT_EQ(end->error_code, bus::WireOf(ErrorCode::kCancelled));
  EXPECT_LT(std::chrono::steady_clock::now() - start, 2s);
}

TEST_F(DiscretizerTest, ANewerAttemptTakesTheOldOnesPlace) {
  shop.Give(FrozenJobOf("again", CubeJob()), 1, "");  // its models never come
  ASSERT_TRUE(shop.AwaitHealth(intaglio_HEALTH_BUSY));
  shop.Give(FrozenJobOf("again", CubeJob()), 2, "");
  ASSERT_TRUE(FeedModels(shop.bus(), "again", 2, {BoxStl(5, 5, 5)}));
  const auto second = shop.AwaitEnd("again", 2);
  ASSERT_TRUE(second);
  EXPECT_EQ(second->state, intaglio_TASK_DONE) << second->message;
}

TEST_F(DiscretizerTest, AConsumerThatGoesFailsTheTask) {
  ASSERT_TRUE(intake.Open("lonely", 1));
  shop.Give(FrozenJobOf("lonely", CubeJob()), 1, "sorter");
  ASSERT_TRUE(shop.AwaitHealth(intaglio_HEALTH_BUSY));
  intake.Close();
  ASSERT_TRUE(FeedModels(shop.bus(), "lonely", 1, {BoxStl(5, 5, 5)}));
  const auto end = shop.AwaitEnd("lonely", 1);
  ASSERT_TRUE(end);
  EXPECT_EQ(end->error_code, bus::WireOf(ErrorCode::kLinkLost)) << end->message;
}

TEST_F(DiscretizerTest, TheEndOfTheJobServiceEndsTheTask) {
  shop.Give(FrozenJobOf("orphan", CubeJob()), 1, "");
  ASSERT_TRUE(shop.AwaitHealth(intaglio_HEALTH_BUSY));
  shop.CloseTasks();
  const auto end = shop.AwaitEnd("orphan", 1);
  ASSERT_TRUE(end);
  EXPECT_EQ(end->error_code, bus::WireOf(ErrorCode::kLinkLost));
  EXPECT_TRUE(shop.AwaitHealth(intaglio_HEALTH_READY));
}

TEST_F(DiscretizerTest, IsMissedWhenItIsKilledInMidWork) {
  shop.Give(FrozenJobOf("killed", CubeJob(0.03)), 1, "");
  ASSERT_TRUE(FeedModels(shop.bus(), "killed", 1, {BoxStl(20, 20, 20)}));
  shop.worker().Kill();
  const auto start = std::chrono::steady_clock::now();
  EXPECT_TRUE(shop.AwaitGone());
  EXPECT_LT(std::chrono::steady_clock::now() - start, 2s);
}

TEST_F(DiscretizerTest, EndsInMidWorkOnRequest) {
  shop.Give(FrozenJobOf("stopped", CubeJob(0.03)), 1, "");
  ASSERT_TRUE(FeedModels(shop.bus(), "stopped", 1, {BoxStl(20, 20, 20)}));
  shop.worker().Signal(SIGTERM);
  EXPECT_EQ(shop.worker().ExitCode(), 0);
}

}  // namespace
}  // namespace intaglio
