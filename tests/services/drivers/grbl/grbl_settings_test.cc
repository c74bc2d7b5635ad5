// The settings of a controller against a profile, and how they are read.

#include "services/drivers/grbl/grbl_settings.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "services/drivers/motion_drivers.h"
#include "services/job/files/job_file.h"
#include "services/virtual_engraver/mill/virtual_grbl.h"

namespace intaglio::drivers {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::StartsWith;
using namespace std::chrono_literals;

MachineSpec Supplied() {
  return ReadMachineFile(INTAGLIO_SOURCE_DIR "/deploy/machines/grbl.textproto").value();
}

/// Settings of a controller that the supplied profile is right for.
GrblSettings Good() {
  GrblSettings settings;
  settings.serial_number = "G-03";
  settings.values = {{10, 2},     {30, 1000}, {31, 0},    {32, 1},
                     {100, 250},  {101, 250}, {102, 250}, {110, 3000},
                     {111, 3000}, {112, 600}, {120, 500}, {121, 500},
                     {122, 100},  {130, 174}, {131, 174}, {132, 84}};
  return settings;
}

TEST(GrblSettingsOf, AGoodControllerDifferInNothing) {
  MachineSpec machine = Supplied();
  EXPECT_THAT(CompareGrbl(machine, Good()), IsEmpty());
  machine.mutable_motion_line()->set_serial_number("G-03");
  EXPECT_THAT(CompareGrbl(machine, Good()), IsEmpty());
  // Only what the driver needs is missed of what is not reported.
  EXPECT_EQ(CompareGrbl(machine, {"", "G-03", {}}).size(), 2u) << "$32, $30";
}

TEST(GrblSettingsOf, EachDifferenceNamesFieldSettingAndRemedy) {
  struct Case {
    int number;
    double value;
    const char *field, *text, *remedy;
  };
  for (const Case& c : {
           Case{32, 0, "motion_line: ", "$32=0", "set $32=1"},
           Case{30, 0, "motion_line: ", "$30=0", "set $30=1000"},
           Case{31, 5, "motion_line: ", "$31=5", "set $31=0"},
           Case{101, 20, "position_tolerance_um: 30 is", "$101=20", "microsteps"},
           Case{110, 500, "x.max_speed_mm_s: 50 ", "$110=500 ", "set it to 3000"},
           Case{112, 599, "z.max_speed_mm_s: 10 ", "$112=599 ", "set it to 600"},
           Case{121, 499, "y.max_acceleration_mm_s2: 500 ", "$121=499 ", "set it to 500"},
           Case{132, 80, "z.travel_max_mm: -2 to 82 ", "$132=80 ", "reduce the travel"},
       }) {
    GrblSettings settings = Good();
    settings.values[c.number] = c.value;
    const auto found = CompareGrbl(Supplied(), settings);
    ASSERT_EQ(found.size(), 1u) << c.number;
    EXPECT_THAT(found[0].message, StartsWith(c.field));
    EXPECT_THAT(found[0].message, HasSubstr(c.text));
    EXPECT_THAT(found[0].message, HasSubstr(c.remedy));
  }
  MachineSpec other = Supplied();
  other.mutable_motion_line()->set_serial_number("G-04");
  const auto found = CompareGrbl(other, Good());
  ASSERT_EQ(found.size(), 1u);
  EXPECT_THAT(found[0].message,
              StartsWith("motion_line.serial_number: \"G-04\" is expected"));
}

TEST(GrblProfileCheck, TheDriverRefusesWhatItLacksByName) {
  EXPECT_THAT(CheckGrblProfile(Supplied()), IsEmpty());
  MachineSpec bare = Supplied();
  bare.mutable_laser()->clear_max_unsettled_points();
  const auto made = MakeMotionDriver(bare);
  ASSERT_FALSE(made);
  EXPECT_EQ(made.error().code, ErrorCode::kMissing);
  EXPECT_THAT(made.error().message, StartsWith("laser.max_unsettled_points: is missing"));
  EXPECT_TRUE(MakeMotionDriver(Supplied()));
  MachineSpec wrong = Supplied();
  wrong.mutable_laser()->mutable_timing()->set_qswitch_delay_us(3);
  wrong.mutable_laser()->set_channels(2);
  wrong.set_pulse_trigger(PULSE_TRIGGER_AT_PLACE);
  std::string all;
  for (const Error& error : CheckGrblProfile(wrong)) all += error.message + "\n";
  EXPECT_THAT(all, HasSubstr("laser.timing: "));
  EXPECT_THAT(all, HasSubstr("laser.channels: 2 "));
  EXPECT_THAT(all, HasSubstr("pulse_trigger: "));
}

/// A controller that lives 5 ms each time it is read.
struct Controller {
  grbl::VirtualGrbl grbl{grbl::Grbl11()};
  std::chrono::nanoseconds now = 1s;
  bool silent = false;

  class End final : public link::ByteStream {
   public:
    explicit End(Controller& controller) : controller_(controller) {}
    Result<std::size_t> Read(std::span<std::byte> buffer) override {
      if (pending_.empty()) {
        controller_.now += 5ms;
        controller_.grbl.Advance(5000);
        pending_ = controller_.grbl.Read();
        if (controller_.silent) pending_.clear();
        if (std::exchange(empties_, !empties_)) return std::size_t{0};
      }
      const std::size_t count = std::min(buffer.size(), pending_.size());
      std::memcpy(buffer.data(), pending_.data(), count);
      pending_.erase(0, count);
      return count;
    }
    Result<std::size_t> Write(std::span<const std::byte> bytes) override {
      controller_.grbl.Write({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
      return bytes.size();
    }
    int fd() const override { return -1; }

   private:
    Controller& controller_;
    std::string pending_;
    bool empties_ = true;
  };

  Result<GrblSettings> Read() {
    return ReadGrblSettings(
        [this]() -> Result<std::unique_ptr<link::ByteStream>> {
          return std::make_unique<End>(*this);
        },
        [this] { return now; });
  }
};

TEST(GrblSettingsReading, MovesNothingAndDropsHalfALine) {
  Controller controller;
  controller.grbl.Write("M4S1000\nG1X10F100");  // without its end
  controller.grbl.Advance(100'000);
  const auto read = controller.Read();
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(read->serial_number, "G-03");
  EXPECT_THAT(read->version, StartsWith("1.1h"));
  EXPECT_EQ(read->values.at(32), 1);
  EXPECT_EQ(read->values.at(102), 250);
  EXPECT_EQ(read->values.at(110), 6000);
  controller.grbl.Advance(1'000'000);
  EXPECT_EQ(controller.grbl.WorkPosition_mm(), Vec3::Zero());
  EXPECT_TRUE(controller.grbl.motion().flashes().empty());
  EXPECT_FALSE(controller.grbl.spindle_on());
}

TEST(GrblSettingsReading, LeavesAControllerAloneThatMovesOrIsSilent) {
  Controller moving;
  moving.grbl.Write("G1X40F600\n");
  moving.grbl.Advance(200'000);
  const auto refused = moving.Read();
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kRefused);
  moving.grbl.Advance(5'000'000);
  EXPECT_NEAR(moving.grbl.WorkPosition_mm().x(), 40, 0.004);
  Controller silent;
  silent.silent = true;
  const auto lost = silent.Read();
  ASSERT_FALSE(lost);
  EXPECT_EQ(lost.error().code, ErrorCode::kLinkLost);
}

}  // namespace
}  // namespace intaglio::drivers
