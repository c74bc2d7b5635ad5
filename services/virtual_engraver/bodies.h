#pragma once

// The bodies of the machine: what hangs around the beam, and what it can run into. As
// steel and glass do, it refuses nothing; where they meet, the record of the glass has
// it. Written for itself: it shares nothing with engrave/machine, so that a wrong sign or
// distance there shows as a collision.
//
// Frame of the table: that of PositionerOptions, which goes with the block, mm.

#include <array>
#include <functional>
#include <limits>
#include <optional>
#include <vector>

#include "engrave/core/geometry.h"
#include "engrave/formats/glass_record.h"
#include "services/virtual_engraver/stations.h"

namespace intaglio::virtual_engraver {

/// An upright cylinder around the beam, without an upper end.
struct HangingBody {
  double above_focus_mm = 0;  ///< its lowest face above the focus in air
  double radius_mm = std::numeric_limits<double>::infinity();
};

struct BodyOptions {
  std::optional<HangingBody> lens = {}, carrier = {};
  std::vector<Box3> obstacles;  ///< from the corner of the first block, as the axes go
};

class Bodies {
 public:
  Bodies(const BodyOptions& options, const BlockInMachine& block,
         std::span<const StationInMachine> further);

  /// None of the head: then nothing can meet.
  bool any() const { return !hanging_.empty(); }

  using Sink = std::function<void(const formats::GlassCollision&)>;
  /// The focus is in air at `focus_mm` now, frame of the table. `sink` gets what begins
  /// to meet, and again what has gone 0.1 mm deeper since.
  void Move(const Vec3& focus_mm, std::uint64_t tick, const Sink& sink);

 private:
  /// A box that stands on the table, turned by `turn_rad` about the origin.
  struct Solid {
    std::uint8_t number = 0;
    Box3 box;
    double turn_rad = 0;
  };
  struct Hanging {
    std::uint8_t number = 0;
    HangingBody body;
    std::vector<double>
        recorded_mm;  // by what stands: the overlap in the record, 0: none
  };

  Vec3 corner_mm_;
  std::vector<Solid> solids_;
  std::vector<Hanging> hanging_;
};

}  // namespace intaglio::virtual_engraver
