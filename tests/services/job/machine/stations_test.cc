#include "services/job/machine/stations.h"

#include <gmock/gmock.h>
#include <google/protobuf/text_format.h>

#include <numbers>

#include "services/job/checks/job_check.h"
#include "services/job/convert/job_defaults.h"
#include "services/job/files/job_file.h"
#include "services/job/machine/block_origin.h"
#include "services/job/machine/machine_axes.h"
#include "tests/services/job/test_job.h"

namespace intaglio {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

MachineSpec With(MachineSpec machine, const std::string& loading) {
  EXPECT_TRUE(
      google::protobuf::TextFormat::ParseFromString(loading, machine.mutable_loading()));
  return machine;
}
MachineSpec Linear(const std::string& loading) { return With(GoodMachine(), loading); }
MachineSpec Polar(const std::string& loading) {
  return With(
      ReadMachineFile(INTAGLIO_SOURCE_DIR "/deploy/machines/polar.textproto").value(),
      loading);
}

/// Checks a block of that size at a station; "" when nothing is wrong.
std::string Wrong(const MachineSpec& machine, std::uint32_t station,
                  const Vec3& size_mm) {
  JobSpec job = GoodJob();
  job.set_station(station);
  Vector3& size = *job.mutable_block()->mutable_size_mm();
  size.set_x(size_mm.x()), size.set_y(size_mm.y()), size.set_z(size_mm.z());
  std::string text;
  for (const Finding& finding : CheckJobOnMachine(job, machine, std::nullopt))
    text += finding.message + "\n";
  return text;
}

std::string ProfileError(const MachineSpec& machine) {
  std::string text;
  for (const Error& error : CheckMachine(machine)) text += error.message + "\n";
  return text;
}

const Vec3 kSmall(40, 40, 30);

TEST(Stations, ByPitchAndByListLieAtTheirOffsets) {
  const MachineSpec row = Linear("station_count: 3 pitch_mm { x: 50 y: -1 }");
  EXPECT_EQ(StationCountOf(row), 3u);
  EXPECT_EQ(StationPlaceOf(row, 1).offset_mm, Vec3::Zero());
  EXPECT_EQ(StationPlaceOf(row, 3).offset_mm, Vec3(100, -2, 0));
  const MachineSpec list = Linear("offsets_mm { x: 50 } offsets_mm { y: 60 z: 1 }");
  EXPECT_EQ(StationCountOf(list), 3u);
  EXPECT_EQ(StationPlaceOf(list, 3).offset_mm, Vec3(0, 60, 1));
  EXPECT_EQ(StationPlaceOf(list, 4).offset_mm, Vec3::Zero()) << "no station";
  EXPECT_EQ(StationCountOf(GoodMachine()), 1u);
}

TEST(Stations, TheOriginOfAJobIsThatOfItsStation) {
  const MachineSpec machine = Linear("station_count: 3 pitch_mm { x: 50 }");
  JobSpec job = WithDefaults(GoodJob(), machine);
  EXPECT_EQ(job.station(), 1u) << "the default";
  const Vec3 first_mm = BlockOriginOf(machine, job);
  job.set_station(3);
  EXPECT_EQ(BlockOriginOf(machine, job), first_mm + Vec3(100, 0, 0));
  EXPECT_EQ(BlockOriginsOf(machine, job).front(), first_mm + Vec3(100, 0, 0));
  EXPECT_FALSE(WithDefaults(GoodJob(), GoodMachine()).has_station());
}

// (8.3): the same place of the block, the table turned on by the constant turn.
TEST(Stations, OfARoundTableDifferByTheTurnOfTheTable) {
  const MachineSpec machine = Polar("station_count: 4 turn_rad: 1.5");
  JobSpec job = GoodJob();
  const Vec3 place_mm(-10, 110, 5);
  const Vec3 near(5, 0, 0);
  const Vec3 first = KinematicsOf(machine, job, {})->ToAxes(place_mm, near).value();
  for (std::uint32_t station = 2; station <= 4; ++station) {
    job.set_station(station);
    const Vec3 axes = KinematicsOf(machine, job, {})->ToAxes(place_mm, near).value();
    EXPECT_NEAR(axes.x(), first.x(), 1e-12);
    EXPECT_NEAR(axes.z(), first.z(), 1e-12);
    const double turned =
        std::remainder(first.y() - axes.y() - 1.5 * (station - 1), 2 * std::numbers::pi);
    EXPECT_NEAR(turned, 0, 1e-12);
  }
}

TEST(Stations, AStationBeyondTheTravelIsNamed) {
  const MachineSpec machine = Linear("station_count: 9 pitch_mm { x: 45 }");
  EXPECT_EQ(Wrong(machine, 1, kSmall), "");
  EXPECT_EQ(Wrong(machine, 2, kSmall), "");
  EXPECT_THAT(Wrong(machine, 9, kSmall),
              HasSubstr("station: 9 is beyond the reach of " + machine.name()));
  EXPECT_THAT(Wrong(machine, 9, kSmall), HasSubstr("does not fit in the travel"));
  EXPECT_THAT(Wrong(machine, 10, kSmall), HasSubstr("give 1 to 9"));
  EXPECT_THAT(Wrong(GoodMachine(), 2, kSmall), HasSubstr("takes one block"));
}

TEST(Stations, BlocksThatWouldOverlapAreRefusedButAtTheFirst) {
  const MachineSpec row = Linear("station_count: 2 pitch_mm { x: 41 }");
  EXPECT_EQ(Wrong(row, 2, Vec3(41, 40, 30)), "") << "they touch";
  EXPECT_THAT(Wrong(row, 2, Vec3(42, 40, 30)), HasSubstr("no room beside station 1"));
  EXPECT_EQ(Wrong(row, 1, Vec3(42, 40, 30)), "") << "alone on the table";
}

// Four blocks of side a, y2 from the axis and symmetric about it: neighbours a quarter
// turn apart meet where a / 2 = y2.
TEST(Stations, TurnedBlocksHaveRoomUntilTheirCornersMeet) {
  MachineSpec machine = Polar("station_count: 4 turn_rad: 1.5707963267948966");
  machine.mutable_block_origin_mm()->set_y(60);
  const auto wrong_with = [&](double width_mm) {
    machine.mutable_block_origin_mm()->set_x(-width_mm / 2);
    return Wrong(machine, 3, Vec3(width_mm, 40, 30));
  };
  EXPECT_EQ(wrong_with(119), "");
  EXPECT_THAT(wrong_with(121), HasSubstr("no room beside station 2"));
}

// (129): y2 + a <= r2.
TEST(Stations, ThePieceLiesOnTheTable) {
  MachineSpec machine = Polar("station_count: 2 turn_rad: 3 table_radius_mm: 140");
  machine.mutable_block_origin_mm()->set_y(90);
  EXPECT_EQ(Wrong(machine, 1, Vec3(50, 50, 30)), "");
  EXPECT_THAT(Wrong(machine, 1, Vec3(50, 51, 30)),
              HasSubstr("does not lie on the table of polar"));
}

TEST(Stations, WrongLoadingsAreNamedWithTheRemedy) {
  EXPECT_THAT(CheckMachine(Linear("station_count: 3 pitch_mm { x: 50 }")), IsEmpty());
  EXPECT_THAT(CheckMachine(Polar("station_count: 4 turn_rad: -1.5707963267948966")),
              IsEmpty());
  EXPECT_THAT(ProfileError(Linear("station_count: 3")),
              HasSubstr("loading.pitch_mm: is missing"));
  EXPECT_THAT(ProfileError(Linear("pitch_mm { x: 50 }")),
              HasSubstr("loading.station_count: is missing"));
  EXPECT_THAT(ProfileError(Linear("station_count: 3 turn_rad: 1 pitch_mm { x: 5 }")),
              HasSubstr("loading.turn_rad: is of an arm and a table"));
  EXPECT_THAT(ProfileError(Linear("station_count: 3 offsets_mm { x: 5 }")),
              HasSubstr("loading.station_count: is given beside offsets_mm"));
  EXPECT_THAT(ProfileError(Polar("offsets_mm { x: 5 }")),
              HasSubstr("loading.offsets_mm: is of linear axes"));
  EXPECT_THAT(ProfileError(Polar("station_count: 4")),
              HasSubstr("loading.turn_rad: is missing"));
  EXPECT_THAT(ProfileError(Polar("station_count: 4 turn_rad: 1.6")),
              HasSubstr("more than a full turn"));
}

}  // namespace
}  // namespace intaglio
