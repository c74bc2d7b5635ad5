#include "services/client/shop/virtual_truth.h"

#include <gtest/gtest.h>

#include <map>
#include <string>

#include "services/job/files/job_file.h"
#include "services/virtual_engraver/truth/truth_check.h"

namespace intaglio::client {
namespace {

TEST(VirtualTruth, IsWhatTheProfileReportsAndWhatIsMounted) {
  auto machine =
      ReadMachineFile(INTAGLIO_SOURCE_DIR "/deploy/machines/els-03.textproto").value();
  machine.mutable_laser()->set_pulse_energy_mj(12);
  machine.mutable_block_origin_mm()->set_y(7);
  machine.mutable_motion_line()->set_serial_number("ST-7");
  const MachineTruth truth =
      TruthOf(machine, {Vec3(50, 60, 70), 1.52, optics::Lens{43, 0.2}});
  EXPECT_TRUE(CheckTruth(truth).empty());
  EXPECT_EQ(truth.stage().travel_min_mm().y(), -2);
  EXPECT_EQ(truth.stage().travel_max_mm().z(), 172);
  EXPECT_EQ(truth.stage().first_order_lag_s(), 0.0002);
  EXPECT_EQ(truth.stage().position_tolerance_um(), 30);
  EXPECT_EQ(truth.stage().serial_number(), "ST-7");
  EXPECT_FALSE(truth.stage().has_repeatability_um());
  EXPECT_FALSE(truth.stage().has_clock_drift_ppm());
  EXPECT_FALSE(truth.stage().has_steps_per_mm());
  EXPECT_EQ(truth.laser().rates_hz_size(), 8);
  EXPECT_EQ(truth.laser().warm_up_s(), 30);
  EXPECT_EQ(truth.laser().channels(), 4u);
  EXPECT_EQ(truth.laser().pulse_energy_mj(), 12);
  EXPECT_FALSE(truth.laser().has_serial_number());
  EXPECT_EQ(truth.block().size_mm().x(), 50);
  EXPECT_EQ(truth.block().origin_mm().y(), 7);
  EXPECT_EQ(truth.block().refractive_index(), 1.52);
  EXPECT_EQ(truth.block().numerical_aperture(), 0.2) << "of the lens that is mounted";
  PulseTiming& timing = *machine.mutable_laser()->mutable_timing();
  EXPECT_FALSE(truth.laser().has_trigger_max_delay_us());
  timing.set_max_qswitch_delay_us(30);
  timing.set_min_qswitch_width_us(90);
  timing.set_min_sync_width_us(4);
  timing.set_min_sensor_width_us(40);
  timing.set_shutter_time_ms(12);
  machine.mutable_y()->set_steps_per_mm(250);
  machine.mutable_second_order()->set_natural_frequency_hz(120);
  machine.mutable_second_order()->set_damping_ratio(0.7);
  const MachineTruth second =
      TruthOf(machine, {Vec3(50, 60, 70), 1.52, optics::Lens{43, 0.2}});
  EXPECT_EQ(second.stage().steps_per_mm().y(), 250);
  EXPECT_EQ(second.stage().steps_per_mm().x(), 0);
  EXPECT_EQ(second.laser().trigger_max_delay_us(), 30);
  EXPECT_EQ(second.laser().trigger_min_width_us(), 90);
  EXPECT_GT(second.laser().sync_width_us(), 4);
  EXPECT_GT(second.laser().sensor_width_us(), 40);
  EXPECT_EQ(second.laser().shutter_time_ms(), 12);
  EXPECT_FALSE(second.stage().has_first_order_lag_s());
  EXPECT_EQ(second.stage().second_order().natural_frequency_hz(), 120);
  EXPECT_EQ(second.stage().second_order().damping_ratio(), 0.7);
}

// Whatever drive the profile has, the machine that it makes is of the same kind and has
// the same numbers.
TEST(VirtualTruth, TheTruthHasTheDriveOfTheProfile) {
  const std::map<std::string, std::string> fields = {{"second_order", "second_order"},
                                                     {"servo", "servo"},
                                                     {"cascade", "cascade"},
                                                     {"stepper_screw", "stepper_screw"},
                                                     {"planar_drive", "planar"}};
  const auto* oneof = MachineSpec::descriptor()->FindOneofByName("drive");
  for (int i = 0; i < oneof->field_count(); ++i) {
    const auto* field = oneof->field(i);
    if (field->message_type() == nullptr) continue;
    auto machine =
        ReadMachineFile(INTAGLIO_SOURCE_DIR "/deploy/machines/els-03.textproto").value();
    auto& message = *MachineSpec::GetReflection()->MutableMessage(&machine, field);
    for (int k = 0; k < field->message_type()->field_count(); ++k) {
      message.GetReflection()->SetDouble(&message, field->message_type()->field(k),
                                         1 + k);
    }
    const TruthStage stage =
        TruthOf(machine, {Vec3(50, 60, 70), 1.52, optics::Lens{43, 0.2}}).stage();
    const auto* of_truth =
        TruthStage::descriptor()->FindFieldByName(fields.at(field->name()));
    ASSERT_TRUE(TruthStage::GetReflection()->HasField(stage, of_truth)) << field->name();
    const auto& drive = TruthStage::GetReflection()->GetMessage(stage, of_truth);
    for (int k = 0; k < field->message_type()->field_count(); ++k) {
      EXPECT_EQ(drive.GetReflection()->GetDouble(
                    drive, drive.GetDescriptor()->FindFieldByName(
                               field->message_type()->field(k)->name())),
                1 + k)
          << field->message_type()->field(k)->full_name();
    }
  }
}

}  // namespace
}  // namespace intaglio::client
