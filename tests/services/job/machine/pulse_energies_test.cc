#include "services/job/machine/pulse_energies.h"

#include <gmock/gmock.h>

#include "services/job/checks/job_check.h"
#include "services/job/convert/job_defaults.h"
#include "tests/services/job/test_job.h"

namespace intaglio {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

/// Three models: the laser's energy, 4 mJ, and again the laser's.
JobSpec ThreeModels() {
  JobSpec job = GoodJob();
  while (job.models_size() < 3) *job.add_models() = job.models(0);
  job.mutable_laser()->set_pulse_energy_mj(20);
  job.mutable_models(1)->set_pulse_energy_mj(4);
  job.mutable_models(2)->set_pulse_energy_mj(20);
  return WithDefaults(job, GoodMachine());
}

TEST(PulseEnergies, AModelWithoutOneHasTheLasers) {
  EXPECT_THAT(EnergiesOfModels(ThreeModels()), ElementsAre(20, 4, 20));
  EXPECT_THAT(DistinctEnergies(ThreeModels()), ElementsAre(4, 20));
  JobSpec without = ThreeModels();
  without.clear_models();
  EXPECT_THAT(EnergiesOfModels(without), ElementsAre(20));
}

TEST(PulseEnergies, APointHasThatOfItsModel) {
  const std::vector<std::uint32_t> source = {2, 1, 0, 1};
  const PointEnergies energies = EnergiesOfPoints(ThreeModels(), source).value();
  EXPECT_THAT(energies.distinct_mj, ElementsAre(4, 20));
  EXPECT_THAT(energies.of_point, ElementsAre(1, 0, 1, 0));
  EXPECT_EQ(energies.Of(3), 4);
  const auto unknown = EnergiesOfPoints(ThreeModels(), std::vector<std::uint32_t>{3});
  ASSERT_FALSE(unknown.has_value());
  EXPECT_THAT(unknown.error().message, HasSubstr("point 0 is of model 3"));

  JobSpec alike = ThreeModels();
  alike.mutable_models(1)->clear_pulse_energy_mj();
  EXPECT_THAT(EnergiesOfPoints(alike, source)->of_point, IsEmpty());
  EXPECT_EQ(EnergiesOfPoints(alike, source)->Of(2), 20);
}

TEST(PulseEnergies, AreOnesThatTheMachineMakes) {
  const auto complaint = [](const JobSpec& job, const MachineSpec& machine) {
    const auto found = CheckJobOnMachine(job, machine, 0.65);
    return found.empty() ? "" : found.front().message;
  };
  JobSpec job = ThreeModels();
  EXPECT_EQ(complaint(job, GoodMachine()), "");
  job.mutable_models(2)->set_pulse_energy_mj(31);
  EXPECT_THAT(complaint(job, GoodMachine()),
              HasSubstr("models[2].pulse_energy_mj: 31 is above the pulse energy"));
  // A controller that switches its laser and no more.
  MachineSpec switched = GoodMachine();
  switched.mutable_laser_line()->set_protocol("motion-output");
  job = ThreeModels();
  job.mutable_laser()->set_pulse_energy_mj(30);
  job.mutable_models(2)->clear_pulse_energy_mj();
  EXPECT_THAT(complaint(job, switched),
              HasSubstr("models[1].pulse_energy_mj: 4 cannot be set on"));
}

}  // namespace
}  // namespace intaglio
