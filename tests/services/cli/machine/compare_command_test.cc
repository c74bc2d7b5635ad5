// `intaglio machine compare` on the supplied profiles.

#include <gmock/gmock.h>
#include <google/protobuf/util/json_util.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <string>

#include "proto/machine_report.pb.h"
#include "services/cli/intaglio_program.h"
#include "tests/services/cli/typed_command.h"
#include "tests/test_folder.h"

namespace intaglio::cli {
namespace {

using testing::AllOf;
using testing::HasSubstr;

constexpr const char* kFolder = INTAGLIO_SOURCE_DIR "/deploy/machines/";

class MachineCompare : public TypedCommand {
 protected:
  int Run(std::vector<std::string> more) {
    std::vector<std::string> words = {"machine", "compare"};
    words.insert(words.end(), more.begin(), more.end());
    words.insert(words.end(), {"--materials", (folder_ / "materials.db").string()});
    return TypeToAll(words);
  }
  static std::string Supplied(const std::string& name) {
    return kFolder + name + ".textproto";
  }
};

TEST_F(MachineCompare, RanksTheSuppliedMachines) {
  ASSERT_EQ(Run({Supplied("els-03"), Supplied("planar"), Supplied("polar"), "--json",
                 "--force", "20", "--block", "30", "30", "20"}),
            0)
      << errors_;
  MachineComparison comparison;
  ASSERT_TRUE(google::protobuf::util::JsonStringToMessage(output_, &comparison).ok());
  std::map<std::string, ComparedMachine> machines;
  for (const ComparedMachine& of : comparison.machines()) machines[of.machine()] = of;
  ASSERT_EQ(machines.size(), 3u);
  // By hand from the profiles: two screws of 40 N/um in series; the planar motor's 2.
  EXPECT_NEAR(machines["els-03"].source_stiffness_n_um(), 20, 1e-9);
  EXPECT_NEAR(machines["els-03"].weakest_n_um(), 40, 1e-9);
  EXPECT_NEAR(machines["els-03"].deflection_um(), 0.5, 1e-9);
  EXPECT_NEAR(machines["planar"].source_stiffness_n_um(), 2, 1e-9);
  EXPECT_EQ(machines["planar"].rule(), "(137)");
  // The arm's 1e5 Nm/rad at 150 mm; the table's 4e5 at the block's far corner, 120 mm up
  // and 25 mm aside.
  const ComparedMachine& polar = machines["polar"];
  EXPECT_NEAR(polar.first_n_um(), 1e5 / (0.15 * 0.15) / 1e6, 1e-9);
  const double far_m2 = 0.120 * 0.120 + 0.025 * 0.025;
  EXPECT_NEAR(polar.second_n_um(), 4e5 / far_m2 / 1e6, 1e-9);
  EXPECT_NEAR(polar.source_stiffness_n_um(), polar.first_n_um() + polar.second_n_um(),
              1e-9);
  EXPECT_LT(polar.weakest_n_um(), polar.first_n_um()) << "both yield";
  EXPECT_LT(polar.min_scale_mm(), polar.max_scale_mm());
  EXPECT_EQ(machines["els-03"].min_scale_mm(), 1);
  for (const auto& [name, of] : machines) {
    EXPECT_GT(of.utilisation(), 0.3) << name;
    EXPECT_NEAR(of.time_s(), static_cast<double>(of.ticks()) / 100, 1e-9) << name;
    EXPECT_NEAR(
        of.utilisation(),
        static_cast<double>(comparison.point_count()) / static_cast<double>(of.ticks()),
        1e-9)
        << name;
  }
  // By hand: a head over the table of els-03 moves from -2 to 172 mm; the planar motor
  // carries a block of 30 mm 174 mm far. The arm's axis is 200 mm from the table's, whose
  // block reaches sqrt(120^2 + 25^2) mm to all sides. At 3.3 rad the arm of 150 mm points
  // away from the table.
  EXPECT_NEAR(machines["els-03"].room_x_mm(), 174, 1e-9);
  EXPECT_NEAR(machines["planar"].room_y_mm(), 30 + 174, 1e-9);
  EXPECT_NEAR(polar.room_y_mm(), 200 - 150 * std::cos(3.3) + std::hypot(120, 25), 1e-9);
  // The arm's side: 150 mm from its axis.
  EXPECT_NEAR(polar.room_x_mm(), 150 + std::hypot(120, 25), 0.1);
  EXPECT_LE(machines["planar"].ticks(), machines["els-03"].ticks());
}

TEST_F(MachineCompare, PrintsATableAndNamesTheProfileThatFails) {
  ASSERT_EQ(Run({Supplied("els-03"), Supplied("grbl")}), 0) << errors_;
  EXPECT_THAT(output_, AllOf(HasSubstr("screw table"), HasSubstr("20 (136)"),
                             HasSubstr("points/tick")));
  EXPECT_EQ(Run({Supplied("polar"), "--block", "400", "50", "30"}), 2);
  EXPECT_THAT(errors_, AllOf(HasSubstr("polar.textproto"), HasSubstr("the arm serves")));
}

}  // namespace
}  // namespace intaglio::cli
