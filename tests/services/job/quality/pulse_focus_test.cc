#include "services/job/quality/pulse_focus.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "materials_db/material_store.h"
#include "services/job/files/material_record.h"
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
  EXPECT_EQ(focus.condition(), kCrackConditionMet);
  EXPECT_EQ(CrackConditionText(focus).find("met: "), 0u);
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
  EXPECT_EQ(focus.condition(), kConditionNotKnown);
  EXPECT_EQ(CrackConditionText(focus), "not known, for want of tensile strength");
  EXPECT_EQ(FocusIn("K9", machine).unknown_size(), 6) << "all but density and expansion";
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

/// A job of these energies in the glass.
FrozenJob JobOf(const std::string& glass, const std::vector<double>& energies_mj) {
  const auto store = materials_db::MaterialStore::Open(test::FreshFolder() / "m.db");
  const auto material = store.value().Find(glass).value();
  FrozenJob job;
  *job.mutable_machine() = GoodMachine();
  *job.mutable_material() = RecordOf(material);
  *job.mutable_optics() =
      RecordOf(materials_db::ComputeOptics(material, 532, 0.058).value(), 532, 0.058);
  job.mutable_job()->mutable_lens()->set_focal_length_mm(43);
  for (const double energy_mj : energies_mj)
    job.mutable_job()->add_models()->set_pulse_energy_mj(energy_mj);
  return job;
}

// Where the glass reaches its strength goes with the cube root of the energy: 117 um at
// 30 mJ (of which a quarter goes through each lens), so the spot of 43 um at 1.5 mJ.
TEST(PulseFocus, AWeakPulseIsAWarningFromTheEnergyThatReachesTheStrengthInItsSpotAlone) {
  const double full_um = FocusIn("soda-lime", GoodMachine()).strained_diameter_um();
  const double limit_mj = 30 * std::pow(43 / full_um, 3);
  EXPECT_GT(limit_mj, 0.5);
  EXPECT_TRUE(PulseWarningsOf(JobOf("soda-lime", {30})).empty());
  EXPECT_TRUE(PulseWarningsOf(JobOf("soda-lime", {30, 1.01 * limit_mj})).empty());
  const Warnings weak = PulseWarningsOf(JobOf("soda-lime", {30, 0.99 * limit_mj}));
  ASSERT_EQ(weak.size(), 1u);
  EXPECT_EQ(weak[0].code, WarningCode::kPulseHeat);
  EXPECT_EQ(weak[0].weight, WarningWeight::kWarning);
  EXPECT_NE(weak[0].text.find("too weak"), std::string::npos) << weak[0].text;
  EXPECT_TRUE(PulseWarningsOf(JobOf("N-BK7", {0.1})).empty()) << "it is not known";
}

// Fused silica hardly expands: 3100 K until it cracks, and it melts at 1600 C.
TEST(PulseFocus, AGlassThatMeltsBeforeItCracksIsAWarning) {
  const Warnings melts = PulseWarningsOf(JobOf("fused-silica", {30}));
  ASSERT_EQ(melts.size(), 1u);
  EXPECT_EQ(melts[0].code, WarningCode::kPulseHeat);
  EXPECT_NE(melts[0].text.find("melts where it should crack"), std::string::npos);
  EXPECT_EQ(PulseFocusOf(JobOf("fused-silica", {30})).condition(), kPulseMelts);
}

}  // namespace
}  // namespace intaglio
