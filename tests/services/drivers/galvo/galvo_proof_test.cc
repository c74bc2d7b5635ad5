// What the virtual head burns is compared with the marks planned: good with correction,
// follower and lead of the servo; as bad as the reference says without each.

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "engrave/galvo/correction_table.h"
#include "engrave/galvo/files/ct5_tables.h"
#include "engrave/proof/mark_comparison.h"
#include "tests/services/drivers/galvo/head_bench.h"

namespace intaglio::drivers {
namespace {

struct WebCase {
  double diameter_mm, beam_mm_s, web_mm_s;
};

/// 500 mm long, its sensor so far before the field.
struct EdgeWave {
  double height_mm = 0, sensor_mm = 0;
};

constexpr WebCase kSlow{1, 500, 100}, kFast{1.5, 1500, 200};
constexpr double kFieldMm = 20;

MachineSpec ProofProfile() {
  MachineSpec machine = HeadProfile();
  machine.mutable_scan_head()->set_field_mm(kFieldMm);
  machine.mutable_scan_head()->set_encoder_count_um(23);
  return machine;
}

/// 24 circles all over the field, through a lens that distorts by 3 % if so.
proof::MarkComparison ProvedOn(const MachineSpec& machine, const WebCase& web,
                               bool distorted, const EdgeWave& edge = {}) {
  auto truth = HeadTruthOf(machine);
  truth.physics.web_mm_s = web.web_mm_s;
  truth.physics.edge_wave_mm = edge.height_mm;
  truth.physics.edge_sensor_mm = edge.sensor_mm;
  if (distorted) {
    truth.physics.half_angle_rad = 0.2;
    truth.physics.lens_ratio = 0.03;
  }
  HeadBench bench(machine, truth);
  EXPECT_TRUE(bench.Connect());
  bench.Until([] { return false; }, 0.5);
  const bool follows =
      !machine.scan_head().has_follow_web() || machine.scan_head().follow_web();
  mark::MarkSet set{{{"pen", web.beam_mm_s, 0.5, 0, 1, 0, 0}}, {}};
  for (int i = 0; i < 24; ++i)
    set.marks.push_back(
        CircleMark({3, -7 + 0.6 * i}, web.diameter_mm, follows ? 60 + 7.0 * i : 0));
  bench.Run(1, set);
  EXPECT_TRUE(bench.Until([&] { return bench.state().settled; }, 20));
  EXPECT_EQ(bench.state().fault, "");
  return proof::CompareMarks(set, bench.Burnt(), true);
}

/// The inverse of the virtual head's own field, as a board's file.
std::string WriteTable() {
  virtual_engraver::HeadPhysicsOptions options;
  options.field_mm = 21;
  options.half_angle_rad = 0.2 * 21 / kFieldMm;
  options.lens_ratio = 0.03 * 21 * 21 / kFieldMm / kFieldMm;
  options.servo_lag_s = 0;
  auto off = galvo::CentredGrid(20.9, 65);
  for (int j = 0; j < off.nodes; ++j)
    for (int i = 0; i < off.nodes; ++i) {
      const Vec2 at = off.PlaceOf(i, j);
      virtual_engraver::HeadPhysics physics(options);
      const auto output = [&](double mm) {
        return static_cast<std::uint16_t>(32768.5 + mm * 65536 / options.field_mm);
      };
      physics.PassTick(output(at.x()), output(at.y()), 1e-5);
      off.values_mm[off.IndexOf(i, j)] = physics.PlaceInField() - at;
    }
  const auto spline = galvo::Interpolation::kSpline;
  const auto deviations = galvo::CorrectionTable::Make(off, spline).value();
  const auto commands =
      galvo::CorrectionTable::Make(galvo::CommandGrid(deviations, 65).value(), spline)
          .value();
  const auto file = std::filesystem::temp_directory_path() /
                    ("proof_" + std::to_string(getpid()) + ".ct5");
  std::ofstream(file, std::ios::binary)
      << galvo::WriteCt5(galvo::Ct5Of(commands, 50000, nullptr).value());
  return file;
}

TEST(GalvoProof, CirclesOfADistortedFieldAreGoodWithItsTable) {
  MachineSpec machine = ProofProfile();
  const std::string file = WriteTable();
  machine.mutable_scan_head()->set_correction_file(file);
  for (const WebCase& web : {kSlow, kFast}) {
    const auto found = ProvedOn(machine, web, true);
    EXPECT_EQ(found.made_count, 24u);
    EXPECT_LE(found.worst.gap_um, 10) << web.web_mm_s;
    EXPECT_LE(found.worst.place_um, 15) << web.web_mm_s;
    EXPECT_LE(found.worst.diameter_um, 5) << web.web_mm_s;
    EXPECT_LE(found.worst.energy_ratio, 0.02) << web.web_mm_s;
    EXPECT_TRUE(found.IsGood(20)) << web.web_mm_s;
  }
  std::filesystem::remove(file);
}

TEST(GalvoProof, WithoutTheTableCirclesAreBesideTheirPlaces) {
  const auto found = ProvedOn(ProofProfile(), kSlow, true);
  EXPECT_EQ(found.made_count, 24u);
  EXPECT_GT(found.worst.place_um, 50);
  EXPECT_FALSE(found.IsGood(20));
}

TEST(GalvoProof, AWebThatIsNotFollowedLeavesCirclesOpen) {
  MachineSpec machine = ProofProfile();
  machine.mutable_scan_head()->set_follow_web(false);
  // Reference: 628 um.
  for (const WebCase& web : {kSlow, kFast}) {
    const auto found = ProvedOn(machine, web, false);
    ASSERT_EQ(found.marks.size(), 24u);
    EXPECT_NEAR(found.marks[0].gap_um.value_or(0), 628, 20);
    EXPECT_FALSE(found.IsGood(20));
  }
}

TEST(GalvoProof, AWaveOfTheEdgeIsFollowedByItsSensor) {
  MachineSpec machine = ProofProfile();
  machine.mutable_scan_head()->set_edge_sensor_mm(100);
  EdgeWave wave{0.2, 100};
  const auto good = ProvedOn(machine, kSlow, false, wave);
  EXPECT_TRUE(good.IsGood(20));
  EXPECT_LE(good.worst.place_um, 15);
  // Read as if it were at the field: off by 2 A sin(pi s / lambda), 235 um.
  machine.mutable_scan_head()->set_edge_sensor_mm(0);
  EXPECT_GT(ProvedOn(machine, kSlow, false, wave).worst.place_um, 100);
}

TEST(GalvoProof, WithoutRunInAndLeadCirclesStayOpen) {
  MachineSpec machine = ProofProfile();
  machine.mutable_scan_head()->set_lead_servo(false);
  machine.mutable_scan_head()->set_run_in_s(0);
  // The mirrors rest before each circle: else a jump's end is burnt, too.
  machine.mutable_scan_head()->set_jump_delay_s(0.003);
  // Reference: 102 and 294 um.
  const auto slow = ProvedOn(machine, kSlow, false),
             fast = ProvedOn(machine, kFast, false);
  EXPECT_NEAR(slow.marks[0].gap_um.value_or(0), 102, 15);
  EXPECT_NEAR(fast.marks[0].gap_um.value_or(0), 294, 40);
  EXPECT_FALSE(slow.IsGood(20) || fast.IsGood(20));
}

TEST(GalvoProof, WithoutTheLeadOfTheServoCirclesShrink) {
  MachineSpec machine = ProofProfile();
  machine.mutable_scan_head()->set_lead_servo(false);
  // Reference: 11 and 58 um.
  EXPECT_NEAR(ProvedOn(machine, kSlow, false).worst.diameter_um, 11, 4);
  const auto fast = ProvedOn(machine, kFast, false);
  EXPECT_NEAR(fast.worst.diameter_um, 58, 6);
  EXPECT_FALSE(fast.IsGood(20));
}

}  // namespace
}  // namespace intaglio::drivers
