#pragma once

// Drive profiles: protobuf text format of proto/drive.proto, checked.

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "engrave/core/result.h"
#include "engrave/drive/sampled_axis.h"
#include "engrave/drive/sizing.h"
#include "engrave/drive/tuning.h"
#include "proto/drive.pb.h"

namespace intaglio {

inline constexpr std::size_t kMaxDriveProfileBytes = 1 << 18;

/// All that is wrong, each with its field; empty: it is good.
std::vector<Error> CheckDriveProfile(const DriveProfile& profile);

/// kTooLarge, kUnreadable with "name:line:column: what", kInvalidValue with all that is
/// wrong, a line each.
Result<DriveProfile> ParseDriveProfile(std::string_view text, const std::string& name);
/// kNotFound and kIo besides.
Result<DriveProfile> ReadDriveProfile(const std::filesystem::path& file);

// Of a checked profile.
drive::Motor MotorOf(const DriveAxis& axis);
drive::ScrewAxis ScrewOf(const DriveAxis& axis);
std::vector<drive::DemandPhase> DemandOf(const DriveProfile& profile);
/// With the inertia of all that turns.
drive::VelocityLoop VelocityLoopOf(const DriveAxis& axis, drive::CylinderRule rule);
/// Volts of one step of the converter: max_control_v / 2^(bits - 1).
double VoltPerStep(const DriveProfile& profile, const DriveAxis& axis);
drive::PositionLoop PositionLoopOf(const DriveProfile& profile, const DriveAxis& axis);
/// As the controller drives it: quantized, limited, with the friction of guides and
/// preload.
drive::SampledAxis SampledAxisOf(const DriveProfile& profile, const DriveAxis& axis,
                                 drive::CylinderRule rule);
drive::TunedAxis TunedAxisOf(const DriveProfile& profile, const DriveAxis& axis,
                             drive::CylinderRule rule);

}  // namespace intaglio
