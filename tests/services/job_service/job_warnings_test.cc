#include "services/job_service/job_warnings.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "services/job/verdict/warnings.h"

namespace intaglio::job_service {
namespace {

using ::testing::ElementsAre;
using ::testing::Field;
using ::testing::HasSubstr;

DiscretizeOutcome Part(std::uint64_t rays, std::uint64_t odd_rays) {
  DiscretizeOutcome part;
  MethodCounts& counts = *part.add_methods();
  counts.set_ray_count(rays);
  counts.set_odd_ray_count(odd_rays);
  return part;
}

TEST(JobWarnings, CountsAreWarnedOfWhenAllPartsAreMade) {
  AttemptOutcomes outcomes;
  outcomes.parts = {Part(100, 3)};
  *outcomes.parts[0].add_warnings() =
      RecordOf(MakeWarning(WarningCode::kOpenSurface, "open"));
  EXPECT_THAT(WarningsOf(outcomes, 2, {}), ElementsAre(Field(&Warning::text, "open")));
  outcomes.parts.push_back(Part(50, 1));
  EXPECT_THAT(WarningsOf(outcomes, 2, {}),
              ElementsAre(Field(&Warning::text, "open"),
                          Field(&Warning::text, HasSubstr("4 of 150 rays"))));
}

TEST(JobWarnings, ThoseOfThePathComeLast) {
  AttemptOutcomes outcomes;
  outcomes.parts = {Part(9, 1)};
  outcomes.sort.emplace();
  *outcomes.sort->add_warnings() =
      RecordOf(MakeWarning(WarningCode::kBreakage, "may break"));
  EXPECT_THAT(WarningsOf(outcomes, 1, {}),
              ElementsAre(Field(&Warning::code, WarningCode::kOddRays),
                          Field(&Warning::code, WarningCode::kBreakage)));
}

}  // namespace
}  // namespace intaglio::job_service
