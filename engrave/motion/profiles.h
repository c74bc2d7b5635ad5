#pragma once

// Every profile by name, and how to make its program: the one list that planners, jobs
// and the command line go by. A new one is a line in profiles.cc, an enumerator of
// Profile and one of MotionProfile in proto/job.proto, with this name in capitals and _
// for -.

#include <memory>
#include <optional>
#include <span>
#include <string_view>

#include "engrave/motion/axis/limits.h"
#include "engrave/motion/axis/profile.h"
#include "engrave/motion/axis/program_options.h"
#include "engrave/motion/step_program.h"

namespace intaglio::motion {

struct ProfileEntry {
  Profile profile;
  std::string_view name;  ///< lower case, hyphenated
  /// rate_hz > 0; the limits are usable.
  std::unique_ptr<StepProgram> (*make)(const Limits& limits, double rate_hz,
                                       const ProgramOptions& options);
};

/// All of them, in the order of Profile; the tests of the programs run over them.
std::span<const ProfileEntry> Profiles();

/// Nothing if there is none of this name.
std::optional<Profile> ProfileByName(std::string_view name);

/// Throws PreconditionError unless the limits and the rate are positive and finite.
std::unique_ptr<StepProgram> MakeStepProgram(Profile profile, const Limits& limits,
                                             double rate_hz,
                                             const ProgramOptions& options = {});

}  // namespace intaglio::motion
