#include "services/job/quality/pulse_focus.h"

#include <gtest/gtest.h>

#include "materials_db/material_store.h"
#include "services/job/material_record.h"
#include "tests/services/job/test_job.h"
#include "tests/test_folder.h"

namespace intaglio {
namespace {

PulseFocusRecord FocusIn(const std::string& glass, const MachineSpec& machine) {
  const auto store = materials_db::MaterialStore::Open(test::FreshFolder() / "m.db");
  const auto material = store.value().Find(glass).value();
  const auto optics = materials_db::ComputeOptics(material, 532, 0.058).value();
  return PulseFocusOf(RecordOf(material), RecordOf(optics, 532, 0.058), machine.laser(),
                      machine.lenses(0));
}

// Trochimczuk 2008, table 8, and a quarter of the pulse for each channel: by hand.
TEST(PulseFocus, OfThePublishedMachine) {
  const PulseFocusRecord focus = FocusIn("soda-lime", GoodMachine());
  EXPECT_EQ(focus.lens(), "f43");
  EXPECT_DOUBLE_EQ(focus.pulse_energy_mj(), 7.5);
  EXPECT_DOUBLE_EQ(focus.spot_diameter_um(), 43);
  EXPECT_DOUBLE_EQ(focus.peak_power_mw(), 0.625);
  // 0.625 MW over a circle of 43 um: 1.4522e-5 cm2.
  EXPECT_NEAR(focus.peak_irradiance_gw_cm2(), 43.04, 0.01);
  EXPECT_EQ(focus.rate_hz(), 100);
  // The source's condition: the crack of 95 um lies between both.
  EXPECT_LT(focus.melted_diameter_um(), 95);
  EXPECT_GT(focus.strained_diameter_um(), 95);
  EXPECT_LT(focus.cooling_s(), 1 / focus.rate_hz());
  EXPECT_LT(focus.next_point_rise_k(), 30);
  EXPECT_LT(focus.crack_growth_s(), 1e-7);
}

TEST(PulseFocus, LeavesOpenWhatIsNotKnown) {
  MachineSpec machine = GoodMachine();
  machine.mutable_laser()->clear_pulse_duration_ns();
  machine.mutable_laser()->clear_split_ratio();
  PulseFocusRecord focus = FocusIn("N-BK7", machine);
  EXPECT_DOUBLE_EQ(focus.pulse_energy_mj(), 30);
  EXPECT_TRUE(focus.has_spot_diameter_um());
  EXPECT_FALSE(focus.has_peak_power_mw());
  EXPECT_FALSE(focus.has_peak_irradiance_gw_cm2());
  EXPECT_TRUE(focus.has_melted_diameter_um());
  EXPECT_FALSE(focus.has_strained_diameter_um()) << "N-BK7 has no strength";
  machine.mutable_laser()->clear_divergence_mrad();
  machine.mutable_laser()->set_pulse_duration_ns(12);
  focus = FocusIn("N-BK7", machine);
  EXPECT_FALSE(focus.has_spot_diameter_um());
  EXPECT_TRUE(focus.has_peak_power_mw());
  EXPECT_FALSE(focus.has_peak_irradiance_gw_cm2());
  const PulseFocusRecord unknown =
      PulseFocusOf({}, {}, machine.laser(), machine.lenses(0));
  EXPECT_FALSE(unknown.has_heated_ratio());
  EXPECT_FALSE(unknown.has_crack_growth_s());
}

}  // namespace
}  // namespace intaglio
