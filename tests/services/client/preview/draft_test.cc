// The draft of a preview against the cloud of the job itself.

#include "services/client/preview/draft.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "materials_db/material_store.h"
#include "services/client/preview/preview_page.h"
#include "services/client/preview/preview_text.h"
#include "services/job/files/freeze.h"
#include "services/job/models/job_cloud.h"
#include "tests/services/job/test_job.h"
#include "tests/test_folder.h"

namespace intaglio::client {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

FrozenJob FrozenWith(double spacing_mm, bool solid = false) {
  JobSpec job = GoodJob();  // a knot of 22 mm
  job.mutable_discretization()->set_min_spacing_mm(spacing_mm);
  if (solid) job.mutable_discretization()->mutable_solid();
  auto store = materials_db::MaterialStore::Open(test::FreshFolder() / "materials.db");
  const auto frozen =
      FreezeJob(job, GoodMachine(), store->Find("N-BK7").value(), {"", 0, "", "1.2.3"});
  EXPECT_TRUE(frozen) << frozen.error().message;
  return frozen.value_or(FrozenJob());
}

void ExpectTheNumberOf(const FrozenJob& job) {
  const auto draft = MakeDraft(job, {});
  const auto made = MakeJobCloud(job.job(), {}, {}, {});
  ASSERT_TRUE(draft && made);
  const auto count = static_cast<double>(made->cloud.size());
  EXPECT_GT(count, kPointsWithoutDraft);
  EXPECT_NEAR(static_cast<double>(draft->figures.point_count()), count, 0.1 * count);
  EXPECT_LT(static_cast<double>(draft->figures.draft_count()), 0.5 * count);
  EXPECT_EQ(draft->points_mm.size(), draft->figures.draft_count());
  Box3 whole, of_draft;
  for (const Vec3& p : made->cloud.points_mm) whole.Extend(p);
  for (const Vec3& p : draft->points_mm) of_draft.Extend(p);
  EXPECT_LT((whole.min_mm - of_draft.min_mm).norm(), 0.5) << "it is at the same place";
  EXPECT_LT((whole.max_mm - of_draft.max_mm).norm(), 0.5);
}

TEST(Draft, KnowsTheNumberOfPointsOfASurface) { ExpectTheNumberOf(FrozenWith(0.1)); }

TEST(Draft, KnowsTheNumberOfPointsOfASolid) { ExpectTheNumberOf(FrozenWith(0.15, true)); }

TEST(Draft, IsMadeOfLargeMeshesAlone) {
  EXPECT_FALSE(MakeDraft(FrozenWith(0.3), {})) << "its preview is there at once";
  FrozenJob job = FrozenWith(0.05);
  job.mutable_job()->mutable_models(0)->set_file("not_there.obj");
  EXPECT_FALSE(MakeDraft(job, {})) << "its preview reports that";
  job.mutable_job()->mutable_models(0)->set_file("name.svg");
  EXPECT_FALSE(MakeDraft(job, {}));
}

// Reading it alone takes longer than people wait for a picture.
TEST(Draft, IsNotMadeOfFilesThatTakeLongToRead) {
  FrozenJob job = FrozenWith(0.1);
  Model& model = *job.mutable_job()->mutable_models(0);
  const auto large = test::FreshFolder() / "large.obj";
  std::filesystem::copy_file(model.file(), large);
  model.set_file(large);
  EXPECT_TRUE(MakeDraft(job, {}));
  std::filesystem::resize_file(large, kMaxDraftBytes + 1);
  EXPECT_FALSE(MakeDraft(job, {}));
}

TEST(Draft, IsMarkedAsOneOnThePage) {
  const auto draft = MakeDraft(FrozenWith(0.1), {});
  ASSERT_TRUE(draft);
  const std::string page = PageOf(*draft);
  EXPECT_THAT(page, AllOf(HasSubstr("verdict draft"), HasSubstr("DRAFT of "),
                          HasSubstr("the preview follows")));
  EXPECT_THAT(page, Not(HasSubstr("READY")));
  EXPECT_THAT(page, Not(HasSubstr("No warnings"))) << "nobody has looked for any";
  ASSERT_EQ(draft->pictures.size(), 1u);
  EXPECT_EQ(draft->pictures[0].png[1], 'P');
}

TEST(Draft, MakesEachSpacingOfAJobLonger) {
  JobSpec job = GoodJob();
  job.mutable_discretization()->set_min_spacing_mm(0.1);
  job.mutable_discretization()->mutable_even()->set_distance_mm(0.12);
  Model& model = *job.mutable_models(0);
  model.set_min_spacing_mm(0.2);
  const double height_mm = model.placement().fit_height_mm();
  const JobSpec draft = WithSpacings(job, 4);
  EXPECT_DOUBLE_EQ(draft.discretization().min_spacing_mm(), 0.4);
  EXPECT_DOUBLE_EQ(draft.discretization().even().distance_mm(), 0.48);
  EXPECT_DOUBLE_EQ(draft.models(0).min_spacing_mm(), 0.8);
  EXPECT_EQ(draft.models(0).placement().fit_height_mm(), height_mm);
  EXPECT_EQ(WithSpacings(job, 1000).models(0).min_spacing_mm(), 10) << "its range";
}

}  // namespace
}  // namespace intaglio::client
