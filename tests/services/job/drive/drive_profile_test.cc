#include "services/job/drive/drive_profile.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <string>

namespace intaglio {
namespace {

using ::testing::HasSubstr;

constexpr const char* kSupplied =
    INTAGLIO_SOURCE_DIR "/deploy/drives/tirnovean-2016.textproto";

std::string SuppliedText() {
  std::ifstream stream(kSupplied);
  return {std::istreambuf_iterator<char>(stream), {}};
}

std::string ErrorAfter(const std::string& from, const std::string& to) {
  std::string text = SuppliedText();
  text.replace(text.find(from), from.size(), to);
  const auto profile = ParseDriveProfile(text, "p.textproto");
  return profile ? "" : profile.error().message;
}

TEST(DriveProfile, TheSuppliedOneIsGoodAndIsConverted) {
  const auto profile = ReadDriveProfile(kSupplied);
  ASSERT_TRUE(profile.has_value()) << profile.error().message;
  ASSERT_EQ(profile->axes_size(), 2);
  const DriveAxis& x = profile->axes(0);
  EXPECT_NEAR(VoltPerStep(*profile, x), 0.00030518, 5e-9);
  // V per mm: Kp Kc 1000 V/m.
  EXPECT_NEAR(PositionLoopOf(*profile, x).volt_per_m, 20480 * 0.00030518 * 1000, 0.1);
  const auto sampled = SampledAxisOf(*profile, x, drive::CylinderRule::kSolid);
  EXPECT_EQ(sampled.period_s, 0.0004);
  EXPECT_EQ(sampled.max_volt, 10);
  EXPECT_EQ(sampled.counts_per_m, 250000);
  EXPECT_GT(sampled.friction_m_s2, 0);
  const auto inertia =
      drive::InertiaOf(ScrewOf(x), MotorOf(x), drive::CylinderRule::kTirnovean2016);
  EXPECT_NEAR(inertia.total_kg_m2, 53.0884e-4, 5e-9);
  EXPECT_EQ(DemandOf(*profile).size(), 4u);
  const auto tuned = TunedAxisOf(*profile, x, drive::CylinderRule::kSolid);
  EXPECT_NEAR(tuned.amplifier_a_per_v, 8.557 / 0.18, 1e-9);
  EXPECT_GT(tuned.moving_current_a, 0);
}

TEST(DriveProfile, AGainWithoutItsUnitIsRefused) {
  EXPECT_THAT(ErrorAfter("unit: DRIVE_PANEL_UNIT_VOLT_PER_MM ", ""),
              HasSubstr("p.textproto: axes[0].panel.unit: is missing"));
}

TEST(DriveProfile, EveryWrongValueIsNamedWithItsField) {
  EXPECT_THAT(ErrorAfter("lead_m: 0.01", "lead_m: 0"),
              HasSubstr("axes[0].screw.lead_m: 0 is outside 0.0001..1"));
  EXPECT_THAT(ErrorAfter("period_s: 0.0004", "period_s: nan"),
              HasSubstr("controller.period_s: nan is outside"));
  EXPECT_THAT(ErrorAfter("name: \"y\"", "name: \"x\""),
              HasSubstr("axes[1].name: \"x\" is that of another axis"));
  EXPECT_THAT(ErrorAfter("mass_kg: 400", "mass: 400"), HasSubstr("p.textproto:"));
  const auto empty = ParseDriveProfile("", "e");
  ASSERT_FALSE(empty.has_value());
  EXPECT_THAT(empty.error().message, HasSubstr("e: axes: is missing"));
  EXPECT_THAT(empty.error().message, HasSubstr("e: demand: is missing"));
  EXPECT_EQ(ReadDriveProfile("/nowhere/p.textproto").error().code, ErrorCode::kNotFound);
  EXPECT_EQ(
      ParseDriveProfile(std::string(kMaxDriveProfileBytes + 1, '#'), "p").error().code,
      ErrorCode::kTooLarge);
}

}  // namespace
}  // namespace intaglio
