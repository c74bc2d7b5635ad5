#pragma once

// The beams of a job at a scan head over the block: how steep and how strong each is at
// its point.

#include "engrave/machine/beam_strength.h"
#include "engrave/optics/machine_frame.h"
#include "proto/machine.pb.h"
#include "proto/task.pb.h"

namespace intaglio {

/// With `beam`, down to `depth_mm`, > 0. Of a machine with head_over_block.
machine::BeamStrength BeamStrengthOf(const MachineSpec& machine,
                                     const optics::FocusedBeam& beam, double depth_mm);

class JobBeams {
 public:
  struct Beam {
    double depth_mm = 0;  ///< of the point below the face
    double tangent = 0;   ///< of the chief ray in air; 1: no beam reaches the point
  };

  /// Of a job whose machine has head_over_block, with its defaults.
  explicit JobBeams(const FrozenJob& job);

  /// `point_mm`: glass frame.
  Beam To(const Vec3& point_mm) const;
  /// Down to the lower face of the block.
  const machine::BeamStrength& strength() const { return strength_; }

 private:
  optics::MachineFromGlass frame_;
  machine::BeamStrength strength_;
};

}  // namespace intaglio
