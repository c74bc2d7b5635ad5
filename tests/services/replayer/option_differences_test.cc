#include "services/replayer/option_differences.h"

#include <gtest/gtest.h>

namespace intaglio::replayer {
namespace {

FrozenJob Job() {
  FrozenJob job;
  job.set_software_version("1");
  job.mutable_job()->mutable_discretization()->set_min_spacing_mm(0.1);
  job.mutable_job()->add_models()->set_file("a.obj");
  return job;
}

TEST(OptionDifferences, NamesTheFieldAndBothValues) {
  const FrozenJob then = Job();
  FrozenJob now = Job();
  now.mutable_job()->mutable_discretization()->set_min_spacing_mm(0.2);
  const auto found = OptionDifferences(then, now);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].field(), "job.discretization.min_spacing_mm");
  EXPECT_EQ(found[0].then(), "0.1");
  EXPECT_EQ(found[0].now(), "0.2");
}

TEST(OptionDifferences, ListsAndAdditionsHaveTheirPlace) {
  const FrozenJob then = Job();
  FrozenJob now = Job();
  now.mutable_job()->mutable_models(0)->set_file("b.obj");
  now.mutable_job()->add_models()->set_file("c.obj");
  const auto found = OptionDifferences(then, now);
  ASSERT_EQ(found.size(), 2u);
  EXPECT_EQ(found[0].field(), "job.models[0].file");
  EXPECT_EQ(found[1].field(), "job.models[1]");
  EXPECT_TRUE(found[1].then().empty());
}

TEST(OptionDifferences, NamesOfTheJobAndTheVersionAreNoOptions) {
  const FrozenJob then = Job();
  FrozenJob now = Job();
  now.set_software_version("2");
  now.set_job_uid("other");
  EXPECT_TRUE(OptionDifferences(then, now).empty());
}

}  // namespace
}  // namespace intaglio::replayer
