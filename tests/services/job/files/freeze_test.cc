#include "services/job/files/freeze.h"

#include <gmock/gmock.h>

#include <cmath>

#include "services/job/files/job_file.h"
#include "services/job/files/material_record.h"
#include "tests/services/job/material_of_record.h"
#include "tests/services/job/test_job.h"

namespace intaglio {
namespace {

using testing::HasSubstr;

// Schott's catalog values of N-BK7.
materials_db::Material NBk7() {
  materials_db::Material material;
  material.name = "N-BK7";
  material.manufacturer = "Schott";
  material.dispersion = {
      optics::DispersionFormula::kSellmeier1,
      {1.03961212, 0.00600069867, 0.231792344, 0.0200179144, 1.01046945, 103.560653},
      0.3,
      2.5};
  material.density_kg_m3 = 2510;
  material.poisson_ratio = 0.206;
  return material;
}

const JobIdentity kIdentity{"7-abc", 0xabc, "/results/7-abc", "0.1.0"};

TEST(FreezeJob, ResolvesEverything) {
  const auto frozen = FreezeJob(GoodJob(), GoodMachine(), NBk7(), kIdentity);
  ASSERT_TRUE(frozen) << frozen.error().message;
  EXPECT_EQ(frozen->job_uid(), "7-abc");
  EXPECT_EQ(frozen->epoch(), 0xabcu);
  EXPECT_EQ(frozen->result_directory(), "/results/7-abc");
  EXPECT_EQ(frozen->job().block().margin_mm(), 3);
  EXPECT_EQ(frozen->machine().name(), "els-03");
  EXPECT_EQ(frozen->material().name(), "N-BK7");
  // Published index at 532 nm, to the five digits given.
  const double n = frozen->optics().refractive_index();
  EXPECT_NEAR(n, 1.51947, 5e-6);
  // The marginal ray of a beam of 5 mm, f = 43 mm, from its angles instead of the closed
  // form.
  const double in_air = std::asin(2.5 / 43);
  const double in_glass = std::asin(2.5 / 43 / n);
  EXPECT_NEAR(frozen->optics().stage_per_glass_ratio(),
              std::tan(in_glass) / std::tan(in_air), 1e-12);
  EXPECT_NEAR(frozen->optics().cone_tangent(), std::tan(in_glass), 1e-12);
  EXPECT_EQ(frozen->job().ordering().anneal().pieces(), 1);
  EXPECT_FALSE(frozen->optics().has_thermal_strength_k());
}

TEST(MaterialRecord, RoundTrip) {
  EXPECT_EQ(MaterialOf(RecordOf(NBk7())), NBk7());
  EXPECT_FALSE(RecordOf(NBk7()).has_melting_point_c());
  EXPECT_EQ(RecordOf(NBk7()).density_kg_m3(), 2510);
}

TEST(MaterialRecord, EveryPropertyTravels) {
  materials_db::Material material = NBk7();
  double value = 1;
  for (const materials_db::PropertyRow& row : materials_db::PropertyRows()) {
    material.*row.value = value++;
  }
  EXPECT_EQ(MaterialOf(RecordOf(material)), material);
}

TEST(FreezeJob, WideBeamsNeedALargerUpRatio) {
  JobSpec job = GoodJob();
  job.mutable_lens()->set_numerical_aperture(0.85);
  job.mutable_ordering()->mutable_kdz();
  const auto frozen = FreezeJob(job, GoodMachine(), NBk7(), kIdentity);
  ASSERT_TRUE(frozen) << frozen.error().message;
  EXPECT_GT(frozen->optics().cone_tangent(), 0.6);
  // A crack of the lens is 0.095 mm wide and 0.135 mm long.
  EXPECT_DOUBLE_EQ(frozen->job().ordering().kdz().up_ratio(),
                   frozen->optics().cone_tangent() + 0.0475 / 0.135);
}

TEST(FreezeJob, TurnsRowsAsTheMachineIsFastest) {
  JobSpec job = GoodJob();
  job.mutable_ordering()->mutable_boustrophedon();
  const auto linear = FreezeJob(job, GoodMachine(), NBk7(), kIdentity);
  ASSERT_TRUE(linear) << linear.error().message;
  EXPECT_TRUE(linear->job().ordering().boustrophedon().has_row_turn_deg());
  EXPECT_EQ(linear->job().ordering().boustrophedon().row_turn_deg(), 0);
  const auto polar =
      ReadMachineFile(INTAGLIO_SOURCE_DIR "/deploy/machines/polar.textproto");
  job.clear_laser();
  const auto turned = FreezeJob(job, polar.value(), NBk7(), kIdentity);
  ASSERT_TRUE(turned) << turned.error().message;
  // 115 mm from the table's axis the table is slower, along x, than the arm, along y.
  EXPECT_EQ(turned->job().ordering().boustrophedon().row_turn_deg(), 90);
  job.mutable_ordering()->mutable_boustrophedon()->set_row_turn_deg(12);
  EXPECT_EQ(FreezeJob(job, polar.value(), NBk7(), kIdentity)
                ->job()
                .ordering()
                .boustrophedon()
                .row_turn_deg(),
            12);
}

TEST(FreezeJob, ReportsAllMistakesOnePerLine) {
  JobSpec job = GoodJob();
  job.mutable_laser()->set_rate_hz(3);
  job.mutable_discretization()->set_min_spacing_mm(0);
  materials_db::Material material = NBk7();
  material.dispersion.min_wavelength_um = 0.9;
  const auto frozen = FreezeJob(job, GoodMachine(), material, kIdentity);
  ASSERT_FALSE(frozen);
  const std::string& message = frozen.error().message;
  EXPECT_THAT(message, HasSubstr("laser.rate_hz: 3 is none"));
  EXPECT_THAT(message, HasSubstr("discretization.min_spacing_mm: 0 is outside"));
  EXPECT_THAT(message, HasSubstr("\nglass: "));
  EXPECT_EQ(std::count(message.begin(), message.end(), '\n'), 2);
}

}  // namespace
}  // namespace intaglio
