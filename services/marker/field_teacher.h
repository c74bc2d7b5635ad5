#pragma once

// The field of a scan head, as a person sees it. Nothing is taught in it: a job has its
// place in the field, whose zero is its middle.

#include <string>
#include <utility>

#include "proto/machine.pb.h"
#include "services/cell/manual/teacher.h"

namespace intaglio::marker {

class FieldTeacher final : public cell::Teacher {
 public:
  /// `profile`: the file that `machine` was read from.
  FieldTeacher(const MachineSpec& machine, std::string profile)
      : field_mm_(machine.scan_head().field_mm()), profile_(std::move(profile)) {}

  cell::TaughtAxes axes() const override;
  std::uint32_t channel_count() const override { return 0; }
  Result<Vec3> AxesAtZero(const intaglio_ManualCommand& command,
                          const Vec3& position) const override;
  Result<std::string> Save(const intaglio_ManualCommand& command,
                           const Vec3& position) override;

 private:
  double field_mm_;
  std::string profile_;
};

}  // namespace intaglio::marker
