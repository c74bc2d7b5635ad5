#pragma once

// What `intaglio drive simulate` is asked for, and its courses of two axes.

#include <optional>
#include <string>

#include "engrave/core/result.h"
#include "proto/drive.pb.h"
#include "proto/drive_report.pb.h"
#include "services/job/drive/drive_profile.h"

namespace intaglio::cli {

inline constexpr auto kSimulatedRule = drive::CylinderRule::kSolid;
/// Samples of a run: what a table and a picture can hold.
inline constexpr double kMaxSimulatedSamples = 2e6;

struct DriveSimulateOptions {
  std::string profile, axis, csv, picture;
  double length_mm = 10, speed_mm_s = 100, acceleration_mm_s2 = 1000, rest_s = 0.1;
  double load_nm = 0;  ///< at the motor, towards -
  std::optional<double> circle_mm, corner_deg;
  int turns = 2;
  bool step = false, ideal = false, json = false, stops = false;

  bool is_course() const { return circle_mm || corner_deg; }
};

/// As its controller drives it, with the load of the options.
drive::SampledAxis SimulatedAxis(const DriveSimulateOptions& options,
                                 const DriveProfile& profile, const DriveAxis& axis);

/// kTooLarge: longer than so many periods of the controller.
Status CheckSampleCount(double total_s, double period_s);

/// Figures of one axis of a run.
DriveSimulation FiguresOfAxis(const std::string& name, std::span<const double> setpoints,
                              std::span<const drive::AxisSample> samples);

/// Runs the circle or the corner on the first two axes, and writes table and picture.
Result<DriveCourse> SimulateCourse(const DriveSimulateOptions& options,
                                   const DriveProfile& profile);
void PrintCourse(const DriveCourse& course);

}  // namespace intaglio::cli
