#include "engrave/motion/profiles.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <set>
#include <string>

#include "engrave/core/check.h"

namespace intaglio::motion {
namespace {

TEST(Profiles, AreInTheirOrderAndEachUnderItsName) {
  std::set<std::string_view> names;
  for (std::size_t i = 0; i < Profiles().size(); ++i) {
    const ProfileEntry& entry = Profiles()[i];
    EXPECT_EQ(static_cast<std::size_t>(entry.profile), i);
    EXPECT_EQ(ProfileByName(entry.name), entry.profile);
    names.insert(entry.name);
  }
  EXPECT_EQ(names.size(), Profiles().size());
  EXPECT_EQ(ProfileByName("s-curve"), std::nullopt);
  EXPECT_EQ(ProfileByName(""), std::nullopt);
}

TEST(Profiles, RefuseWhatIsNoMachine) {
  const double infinite = std::numeric_limits<double>::infinity();
  for (const ProfileEntry& entry : Profiles()) {
    Limits limits;
    EXPECT_THROW(MakeStepProgram(entry.profile, limits, 0.0), PreconditionError);
    EXPECT_THROW(MakeStepProgram(entry.profile, limits, infinite), PreconditionError);
    limits.max_acceleration_mm_s2.x() = -1;
    EXPECT_THROW(MakeStepProgram(entry.profile, limits, 100.0), PreconditionError);
  }
  EXPECT_THROW(MakeStepProgram(static_cast<Profile>(99), {}, 100.0), PreconditionError);
}

TEST(Profiles, RefuseAStepThatTakesYears) {
  const Limits limits{Vec3::Constant(1e-9), Vec3::Constant(1e-9)};
  for (const ProfileEntry& entry : Profiles()) {
    std::vector<Segment> out;
    const auto program = MakeStepProgram(entry.profile, limits, 1000.0);
    EXPECT_THROW(program->Append(Vec3::Zero(), Vec3(300, 0, 1), out), PreconditionError)
        << entry.name;
  }
}

}  // namespace
}  // namespace intaglio::motion
