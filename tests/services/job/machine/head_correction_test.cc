// Correction files of a head over the block. The judge is a field that is wrong by a
// formula, and rays that are refracted here.

#include <gmock/gmock.h>

#include <Eigen/Geometry>
#include <filesystem>
#include <fstream>
#include <functional>
#include <string>

#include "engrave/optics/focus.h"
#include "services/job/checks/job_check.h"
#include "services/job/convert/job_defaults.h"
#include "services/job/files/job_file.h"
#include "services/job/head/field_table.h"
#include "services/job/machine/head_over_block.h"
#include "services/job/machine/machine_axes.h"
#include "services/job/machine/machine_defaults.h"
#include "tests/engrave/galvo/files/written_corrections.h"
#include "tests/services/job/test_job.h"

namespace intaglio {
namespace {

namespace fs = std::filesystem;
using testing::Contains;
using testing::Field;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr double kIndex = 1.519473, kBlockMm = 60, kFieldMm = 80;
constexpr double kPencil = 1e-4;  // its aberrations are below a nanometre
constexpr galvo::WrongField kField{0.03};

class HeadCorrection : public testing::Test {
 protected:
  HeadCorrection() { fs::create_directories(folder_); }

  /// galvo-glass with this file beside it.
  fs::path ProfileWith(const std::string& name, const std::string& bytes,
                       const std::function<void(MachineSpec&)>& change = {}) const {
    std::ofstream(folder_ / name, std::ios::binary) << bytes;
    MachineSpec machine =
        ReadMachineFile(INTAGLIO_SOURCE_DIR "/deploy/machines/galvo-glass.textproto")
            .value();
    HeadOverBlockKinematics& head = *machine.mutable_head_over_block();
    head.set_correction_file(name);
    if (name.ends_with(".ctb")) head.set_correction_field_mm(kFieldMm);
    if (change) change(machine);
    const fs::path file = folder_ / (name + ".textproto");
    EXPECT_TRUE(WriteMachineFile(file, machine));
    return file;
  }

  fs::path folder_ = fs::path(testing::TempDir()) / "head_correction";
};

FrozenJob JobOn(const MachineSpec& machine) {
  FrozenJob frozen;
  *frozen.mutable_machine() = WithMachineDefaults(machine);
  JobSpec job = GoodJob();
  job.clear_lens();
  Vector3& size_mm = *job.mutable_block()->mutable_size_mm();
  size_mm.set_x(kBlockMm), size_mm.set_y(kBlockMm), size_mm.set_z(kBlockMm);
  *frozen.mutable_job() = WithDefaults(job, frozen.machine());
  frozen.mutable_job()->mutable_lens()->set_numerical_aperture(kPencil);
  frozen.mutable_optics()->set_stage_per_glass_ratio(
      optics::StagePerGlassRatio(kIndex, kPencil));
  return frozen;
}

/// By Snell's law in vectors; z down from the face.
Vec3 Refracted(const Vec3& way) {
  const double ratio = 1 / kIndex;
  Vec3 inside = ratio * way;
  inside.z() += std::sqrt(1 - ratio * ratio * (1 - way.z() * way.z())) - ratio * way.z();
  return inside;
}

/// The mean of the places where rays on four sides come nearest to the chief ray, in the
/// glass frame, for commands and height of the axes.
Vec3 Traced(const Vec3& axes) {
  const Vec2 field_mm = kField.Arrive(axes.head<2>());
  const Vec3 aim_mm(field_mm.x(), field_mm.y(), kBlockMm - axes.z());
  const Vec3 chief = Vec3(field_mm.x() / 140, field_mm.y() / 135, 1).normalized();
  const Vec3 beside = chief.cross(Vec3::UnitZ()).normalized();
  const Vec3 outward = chief.cross(beside);
  const auto at_face = [&](const Vec3& way) {
    return Vec3(aim_mm - aim_mm.z() / way.z() * way);
  };
  const Vec3 chief_inside = Refracted(chief);
  Vec3 sum_mm = Vec3::Zero();
  for (const Vec3& side : {beside, Vec3(-beside), outward, Vec3(-outward)}) {
    const Vec3 way = (chief + kPencil * side).normalized();
    const Vec3 inside = Refracted(way);
    const Vec3 normal = chief_inside.cross(inside).cross(chief_inside);
    const double reach = normal.dot(at_face(chief) - at_face(way)) / normal.dot(inside);
    sum_mm += at_face(way) + reach * inside;
  }
  const Vec3 middle_mm = sum_mm / 4;
  return {middle_mm.x() + kBlockMm / 2, middle_mm.y() + kBlockMm / 2,
          kBlockMm - middle_mm.z()};
}

struct Miss {
  double across_mm = 0, depth_mm = 0;
};

Miss LargestMissOn(const MachineSpec& machine) {
  const machine::AxesFromGlass axes_from_glass = AxesFromGlassOf(JobOn(machine));
  Miss miss;
  for (const double x : {4.0, 17.0, 30.5, 55.0}) {
    for (const double y : {6.0, 33.0, 54.0}) {
      for (const double z : {3.0, 30.0, 55.0}) {
        const Vec3 point_mm(x, y, z);
        const Vec3 axes = axes_from_glass.ToAxes(point_mm, Vec3::Zero()).value();
        EXPECT_LT((axes_from_glass.ToGlass(axes) - point_mm).norm(), 1e-8);
        const Vec3 away_mm = Traced(axes) - point_mm;
        miss.across_mm = std::max(miss.across_mm, away_mm.head<2>().norm());
        miss.depth_mm = std::max(miss.depth_mm, std::abs(away_mm.z()));
      }
    }
  }
  return miss;
}

// Half a unit of a table of 16 bits is 0.6 um on each axis, one of 20 bits 0.04 um.
TEST_F(HeadCorrection, PutsTheFocusOfATracedBeamOnThePointWhateverTheFile) {
  const struct {
    const char* name;
    std::string bytes;
    double across_mm;
  } kinds[] = {{"a.cor", galvo::CorBytes(kField, kFieldMm), 0.0015},
               {"a.ctb", galvo::CtbBytes(kField, kFieldMm), 0.0015},
               {"a.ct5", galvo::Ct5Bytes(kField, kFieldMm), 0.0005}};
  for (const auto& kind : kinds) {
    const auto machine = ReadMachineFile(ProfileWith(kind.name, kind.bytes));
    ASSERT_TRUE(machine) << machine.error().message;
    const Miss miss = LargestMissOn(*machine);
    EXPECT_LT(miss.across_mm, kind.across_mm) << kind.name;
    EXPECT_LT(miss.depth_mm, 0.002) << kind.name;
    // Without the table it is as wrong as the table is large.
    MachineSpec without = *machine;
    without.mutable_head_over_block()->clear_correction_file();
    without.mutable_head_over_block()->clear_correction_table();
    EXPECT_NEAR(LargestMissOn(without).across_mm, kField.CorrectionAt({26, 24}).norm(),
                0.006);
  }
}

// What a job was frozen with stays, whatever becomes of the file.
TEST_F(HeadCorrection, TravelsWithTheJob) {
  const fs::path profile = ProfileWith("a.cor", galvo::CorBytes(kField, kFieldMm));
  const MachineSpec machine = ReadMachineFile(profile).value();
  fs::remove(folder_ / "a.cor");
  EXPECT_LT(LargestMissOn(machine).across_mm, 0.0015);
  EXPECT_FALSE(ReadMachineFile(profile)) << "the file is missing";
}

// In another folder it names the same file, and does not have its contents.
TEST_F(HeadCorrection, ACopyOfTheProfileNamesTheFile) {
  const MachineSpec machine =
      ReadMachineFile(ProfileWith("a.cor", galvo::CorBytes(kField, kFieldMm))).value();
  fs::create_directories(folder_ / "copy");
  ASSERT_TRUE(WriteMachineFile(folder_ / "copy/m.textproto", machine));
  EXPECT_LT(fs::file_size(folder_ / "copy/m.textproto"), 10'000u);
  const auto copy = ReadMachineFile(folder_ / "copy/m.textproto");
  ASSERT_TRUE(copy) << copy.error().message;
  EXPECT_EQ(copy->head_over_block().correction_table().SerializeAsString(),
            machine.head_over_block().correction_table().SerializeAsString());
}

MachineSpec Board() {
  return ReadMachineFile(INTAGLIO_SOURCE_DIR "/deploy/machines/bjjcz-glass.textproto")
      .value();
}

// A board that is given the table adds it: the commands are places of the field.
TEST_F(HeadCorrection, IsNotAddedTwiceWhereTheBoardAddsIt) {
  const std::string file = (folder_ / "board.cor").string();
  std::ofstream(file, std::ios::binary) << galvo::CorBytes(kField, 110);
  const auto axes_of = [](const MachineSpec& machine) {
    return AxesFromGlassOf(JobOn(machine)).ToAxes({50, 20, 30}, Vec3::Zero()).value();
  };
  MachineSpec by_board = Board();
  by_board.mutable_scan_head()->set_correction_file(file);
  EXPECT_THAT(CheckMachine(by_board), IsEmpty());
  EXPECT_EQ(axes_of(by_board), axes_of(Board()));
  MachineSpec by_host = Board();
  by_host.mutable_head_over_block()->set_correction_file(file);
  EXPECT_THAT(CheckMachine(by_host), IsEmpty());
  const Vec2 place_mm = axes_of(Board()).head<2>();
  EXPECT_LT(
      (axes_of(by_host).head<2>() - place_mm - kField.CorrectionAt(place_mm)).norm(),
      0.002);
  MachineSpec both = by_board;
  both.mutable_head_over_block()->set_correction_file(file);
  EXPECT_THAT(CheckMachine(both),
              Contains(Field(&Error::message, HasSubstr("so does the board"))));
}

TEST_F(HeadCorrection, RefusesWhatItCannotUseWithItsField) {
  const auto errors_of = [&](const std::string& name, const std::string& bytes,
                             const std::function<void(MachineSpec&)>& change = {}) {
    const auto machine = ReadMachineFile(ProfileWith(name, bytes, change));
    return machine ? std::string() : machine.error().message;
  };
  EXPECT_THAT(errors_of("a.txt", "x"), HasSubstr("head_over_block.correction_file: '"));
  EXPECT_THAT(errors_of("b.cor", "x"), HasSubstr("begins with neither"));
  const std::string good = galvo::CorBytes(kField, kFieldMm);
  EXPECT_THAT(
      errors_of("c.cor", good,
                [](MachineSpec& m) {
                  m.mutable_head_over_block()->mutable_correction()->set_focal_mm(100);
                }),
      HasSubstr("so does correction; remove one of them"));
  EXPECT_THAT(errors_of("d.cor", good,
                        [](MachineSpec& m) {
                          m.mutable_head_over_block()->set_correction_field_mm(80);
                        }),
              HasSubstr("head_over_block.correction_field_mm: is of a .ctb file"));
  EXPECT_THAT(errors_of("e.cor", good,
                        [](MachineSpec& m) {
                          m.mutable_scan_head()->set_field_mm(80);
                          m.mutable_scan_head()->set_jump_mm_s(8000);
                          m.mutable_scan_head()->set_correction_file("e.cor");
                        }),
              HasSubstr("scan_head.correction_file: is loaded into a board"));
  MachineSpec machine =
      ReadMachineFile(ProfileWith("f.ctb", galvo::CtbBytes(kField, 80))).value();
  machine.mutable_head_over_block()->clear_correction_table();
  machine.mutable_head_over_block()->clear_correction_field_mm();
  EXPECT_THAT(CheckMachine(machine),
              Contains(Field(&Error::message, HasSubstr("give correction_field_mm"))));
  machine.mutable_head_over_block()->mutable_correction_table()->set_nodes_a_side(3);
  machine.mutable_head_over_block()->mutable_correction_table()->set_pitch_mm(1);
  EXPECT_THAT(CheckMachine(machine),
              Contains(Field(&Error::message, HasSubstr("0 and 0 numbers of 3 nodes"))));
}

}  // namespace
}  // namespace intaglio
