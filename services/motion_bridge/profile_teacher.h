#pragma once

// Teaches a machine whose axes its profile has: positions, zeros and limits are saved in
// the profile, each change as a version with its history.

#include <filesystem>
#include <string>
#include <utility>

#include "proto/machine.pb.h"
#include "services/cell/manual/teacher.h"

namespace intaglio::motion_bridge {

class ProfileTeacher final : public cell::Teacher {
 public:
  /// `profile`: the file that `machine` was read from.
  ProfileTeacher(const MachineSpec& machine, std::filesystem::path profile)
      : machine_(machine), profile_(std::move(profile)) {}

  cell::TaughtAxes axes() const override;
  std::uint32_t channel_count() const override { return machine_.laser().channels(); }
  Result<Vec3> AxesAtZero(const intaglio_ManualCommand& command,
                          const Vec3& position) const override;
  Result<std::string> Save(const intaglio_ManualCommand& command,
                           const Vec3& position) override;

 private:
  Result<std::string> Change(const intaglio_ManualCommand& command,
                             const Vec3& position) const;

  MachineSpec machine_;
  std::filesystem::path profile_;
};

}  // namespace intaglio::motion_bridge
