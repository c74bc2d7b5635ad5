#include "engrave/motion/profiles.h"

#include <algorithm>
#include <cmath>

#include "engrave/core/check.h"
#include "engrave/motion/course_program.h"
#include "engrave/motion/interpolator_program.h"
#include "engrave/motion/lq_program.h"
#include "engrave/motion/parabola_program.h"

namespace intaglio::motion {
namespace {

template <Profile kProfile>
std::unique_ptr<StepProgram> MakeCourse(const Limits& limits, double rate_hz,
                                        const ProgramOptions&) {
  return std::make_unique<CourseProgram>(limits, rate_hz, kProfile);
}

template <typename Program>
std::unique_ptr<StepProgram> Make(const Limits& limits, double rate_hz,
                                  const ProgramOptions&) {
  return std::make_unique<Program>(limits, rate_hz);
}

std::unique_ptr<StepProgram> MakeParabola(const Limits& limits, double rate_hz,
                                          const ProgramOptions& options) {
  return std::make_unique<ParabolaProgram>(limits, rate_hz, options.parabola_height_mm);
}

std::unique_ptr<StepProgram> MakeLq(const Limits& limits, double rate_hz,
                                    const ProgramOptions& options) {
  std::optional<double> rate_per_s;
  if (options.lq) rate_per_s = LqRatePerS(*options.lq);
  return std::make_unique<LqProgram>(limits, rate_hz, rate_per_s);
}

constexpr ProfileEntry kProfiles[] = {
    {Profile::kTriangle, "triangle", MakeCourse<Profile::kTriangle>},
    {Profile::kTrapezoid, "trapezoid", MakeCourse<Profile::kTrapezoid>},
    {Profile::kCubic, "cubic", MakeCourse<Profile::kCubic>},
    {Profile::kMix, "mix", MakeCourse<Profile::kMix>},
    {Profile::kTimeOptimal, "time-optimal", Make<TimeOptimalProgram>},
    {Profile::kInterpolator, "interpolator", Make<InterpolatorProgram>},
    {Profile::kParabola, "parabola", MakeParabola},
    {Profile::kLq, "lq", MakeLq},
};

}  // namespace

std::span<const ProfileEntry> Profiles() { return kProfiles; }

std::optional<Profile> ProfileByName(std::string_view name) {
  for (const ProfileEntry& entry : kProfiles) {
    if (entry.name == name) return entry.profile;
  }
  return std::nullopt;
}

std::unique_ptr<StepProgram> MakeStepProgram(Profile profile, const Limits& limits,
                                             double rate_hz,
                                             const ProgramOptions& options) {
  RequireUsable(limits);
  Require(rate_hz > 0.0 && std::isfinite(rate_hz), "rate_hz must be positive, is {}",
          rate_hz);
  const auto* const entry = std::ranges::find(kProfiles, profile, &ProfileEntry::profile);
  Require(entry != std::end(kProfiles), "there is no profile {}",
          static_cast<int>(profile));
  return entry->make(limits, rate_hz, options);
}

}  // namespace intaglio::motion
