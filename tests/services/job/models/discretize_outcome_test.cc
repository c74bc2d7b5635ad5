#include "services/job/models/discretize_outcome.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "services/job/convert/job_defaults.h"
#include "tests/services/job/test_job.h"

namespace intaglio {
namespace {

using ::testing::HasSubstr;

TEST(DiscretizeOutcome, PartsAddUp) {
  JobSources sources;
  sources.meshes.resize(1);
  sources.meshes[0].set_triangle_count(12);
  sources.warnings = {MakeWarning(WarningCode::kOpenSurface, "the model is open")};
  discretize::Discretized made;
  made.cloud.Add(Vec3(1, 2, 3), 0);
  made.candidate_count = 4;
  made.thinned_count = 2;
  made.clipped_count = 1;
  made.models.resize(1);
  made.models[0].point_count = 4;
  made.models[0].ray_count = 10;
  made.models[0].odd_ray_count = 1;
  made.models[0].parallel_area_mm2 = 20;
  DiscretizeOutcome all;
  AddPart(OutcomeOf(sources, made, {0, 2}), all);
  AddPart(OutcomeOf(sources, made, {1, 2}), all);
  EXPECT_EQ(all.models_size(), 1) << "models are told of once";
  EXPECT_EQ(all.warnings_size(), 1);
  EXPECT_EQ(all.candidate_count(), 8u);
  EXPECT_EQ(all.thinned_count(), 4u);
  EXPECT_EQ(all.clipped_count(), 2u);
  EXPECT_EQ(all.point_count(), 2u);
  ASSERT_EQ(all.methods_size(), 1);
  EXPECT_EQ(all.methods(0).odd_ray_count(), 2u);
  EXPECT_EQ(all.methods(0).parallel_area_mm2(), 40);
}

TEST(DiscretizeOutcome, ParallelFacesAreWarnedOfWhereTheJobAsksForAReport) {
  JobSpec job = GoodJob();
  DiscretizeOutcome all;
  all.add_methods()->set_parallel_area_mm2(40);
  all.mutable_methods(0)->set_odd_ray_count(3);
  EXPECT_EQ(WarningsOf(all, WithDefaults(job, GoodMachine())).size(), 1u);
  job.mutable_discretization()->mutable_sections()->set_parallel_faces(
      PARALLEL_FACES_REPORT);
  const auto warnings = WarningsOf(all, WithDefaults(job, GoodMachine()));
  ASSERT_EQ(warnings.size(), 2u);
  EXPECT_THAT(warnings[0].text, HasSubstr("40.00 mm^2"));
  EXPECT_EQ(warnings[1].code, WarningCode::kOddRays);
}

}  // namespace
}  // namespace intaglio
