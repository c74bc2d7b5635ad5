#include <gtest/gtest.h>

#include "services/job/convert/job_defaults.h"
#include "services/job/files/job_file.h"
#include "tests/services/job/test_job.h"

namespace intaglio {
namespace {

double SpacingWith(double focal_length_mm, const MachineSpec& machine) {
  JobSpec job = GoodJob();
  job.mutable_discretization()->clear_min_spacing_mm();
  job.mutable_lens()->Clear();
  job.mutable_lens()->set_focal_length_mm(focal_length_mm);
  return WithDefaults(job, machine).discretization().min_spacing_mm();
}

// Annex A, 6: 0.09 mm with f = 43 mm, 0.13 mm with f = 70 mm.
TEST(LensSpacing, IsThePublishedOneOfEachLens) {
  const auto machine = ReadMachineFile(std::string(INTAGLIO_SOURCE_DIR) +
                                       "/deploy/machines/els-03.textproto");
  ASSERT_TRUE(machine) << machine.error().message;
  EXPECT_DOUBLE_EQ(SpacingWith(43, *machine), 0.09);
  EXPECT_DOUBLE_EQ(SpacingWith(70, *machine), 0.13);
  EXPECT_EQ(SpacingWith(50, *machine), 0) << "no lens of the machine proposes one";
}

TEST(LensSpacing, WhatTheJobAsksForStays) {
  JobSpec job = GoodJob();
  job.mutable_discretization()->set_min_spacing_mm(0.31);
  EXPECT_EQ(WithDefaults(job, GoodMachine()).discretization().min_spacing_mm(), 0.31);
}

}  // namespace
}  // namespace intaglio
