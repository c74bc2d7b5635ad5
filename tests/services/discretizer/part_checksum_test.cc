// The checksum of a part is the same whoever makes it.

#include <gtest/gtest.h>

#include "services/discretizer/discretize_job.h"
#include "services/platform/host/stage/flow.h"
#include "services/platform/host/threads/worker_threads.h"
#include "tests/services/discretizer/box_model.h"
#include "tests/services/platform/host/stage/stage_shop.h"

namespace intaglio {
namespace {

using test::BoxStl;
using test::FeedModels;
using test::FrozenJobOf;
using test::StageShop;

/// Walls between the planes and faces in them, so that every kind of point is in it.
FrozenJob BoxJobOf(const std::string& uid) {
  JobSpec spec;
  spec.add_models()->set_file("/nowhere/box.stl");
  auto& size = *spec.mutable_block()->mutable_size_mm();
  size.set_x(30), size.set_y(30), size.set_z(30);
  spec.mutable_discretization()->set_min_spacing_mm(0.2);
  spec.mutable_discretization()->mutable_sections();
  return FrozenJobOf(uid, spec);
}

FileBytes BytesOf(const std::string& text) {
  const auto bytes = std::as_bytes(std::span(text));
  return {bytes.begin(), bytes.end()};
}

const ProgressSink kGoOn = [](std::uint64_t, std::uint64_t) { return true; };

/// Makes the second part of three by this many threads.
std::string ChecksumBy(std::size_t threads) {
  const auto prepared =
      discretizer::PrepareJob(BoxJobOf("box"), {BytesOf(BoxStl(17, 8, 19))}, {}, kGoOn);
  EXPECT_TRUE(prepared);
  const auto part =
      discretizer::DiscretizePart(**prepared, {1, 3}, host::OnThreads(threads), kGoOn);
  EXPECT_TRUE(part);
  return part->outcome.discretize().checksum();
}

// The text is that of the release build of x86-64: a debug build, a sanitizer and another
// compiler have to have the same.
TEST(PartChecksum, IsTheSameInEveryBuildAndWithAnyNumberOfThreads) {
  EXPECT_EQ(ChecksumBy(1), "15289-a6975fc0");
  EXPECT_EQ(ChecksumBy(2), ChecksumBy(1));
  EXPECT_EQ(ChecksumBy(7), ChecksumBy(1));
}

TEST(PartChecksum, TheProgramReportsItAndSendsNothingOfAComparison) {
  StageShop shop("intaglio-discretizer", intaglio_STAGE_DISCRETIZE, bus::kDiscretizeTask);
  host::PointIntake intake(shop.bus(), "sorter", bus::kPointBatch);
  ASSERT_TRUE(shop.AwaitHealth(intaglio_HEALTH_READY));
  ASSERT_TRUE(intake.Open("box", 1, 3));
  const host::TaskPart part{1, 3, host::kMaxPartAttempts};
  // With a consumer, which would fail the job at a batch of an attempt that it does not
  // know.
  shop.Give(BoxJobOf("box"), 1, "sorter", part);
  ASSERT_TRUE(FeedModels(shop.bus(), "box", 1, {BoxStl(17, 8, 19)}, part));
  const auto end = shop.AwaitEnd("box", 1, part);
  ASSERT_TRUE(end);
  EXPECT_EQ(end->state, intaglio_TASK_DONE) << end->message;
  EXPECT_EQ(end->outcome.discretize().checksum(), ChecksumBy(1));
  // What follows comes after what would have been sent.
  for (const std::uint32_t index : {0u, 1u, 2u}) {
    shop.Give(BoxJobOf("box"), 1, "sorter", {index, 3, 0});
    Result<bool> taken = false;
    ASSERT_TRUE(test::Eventually([&] {
      taken = intake.Poll();
      return !taken || shop.Find("box", {index, 3, 0}, intaglio_TASK_DONE);
    }));
    ASSERT_TRUE(taken) << taken.error().message;
  }
  EXPECT_EQ(
      shop.Find("box", {1, 3, 0}, intaglio_TASK_DONE)->outcome.discretize().checksum(),
      ChecksumBy(1));
  const host::TaskPart none{1, 3, host::kMaxPartAttempts + host::kMaxComparisons};
  shop.Give(BoxJobOf("box"), 1, "", none);
  const auto refused = shop.AwaitEnd("box", 1, none);
  ASSERT_TRUE(refused);
  EXPECT_EQ(refused->state, intaglio_TASK_FAILED);
}

}  // namespace
}  // namespace intaglio
