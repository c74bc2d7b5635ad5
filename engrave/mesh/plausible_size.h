#pragma once

// Whether the size of a placed model is plausible for its block. Most files carry no
// unit: an inch or a metre that is taken for a millimetre gives a model that is 25 times
// too small, or one of 70 m. The check takes the bounding box alone, so that it comes
// before anything that costs time in proportion to the model's surface.

#include <optional>
#include <string_view>

#include "engrave/core/geometry.h"
#include "engrave/core/warning.h"

namespace intaglio::mesh {

struct SizeInBlock {
  Vec3 size_mm = Vec3::Zero();        ///< of the placed model
  Vec3 block_size_mm = Vec3::Zero();  ///< each side positive
  double unit_mm = 1;                 ///< that was applied, positive
  /// The size was chosen by a fit: no unit changes it.
  bool fitted = false;
  bool clip = false;  ///< points outside the block are dropped
  double min_spacing_mm = 0;
  /// What block_size_mm is the size of, for the sentence.
  std::string_view room = "the block";
};

struct SizeFault {
  bool refused = false;  ///< it cannot be engraved
  /// kImplausibleSize; begins with the model's name, ends with the flags to give.
  Warning warning;
};

/// Nothing when the size is plausible.
///   refused  larger than the block by more than a tenth (with clip: a hundred times
///            larger), or its largest extent is less than the minimum spacing
///   warning  larger than the block, or its largest extent is below 2 % of the block's
///            smallest side, or below 2 mm
///   note     its largest extent is below a tenth of the block's smallest side, and
///            another unit would give a plausible size
/// A fitted model is never too small. The sentence names the units that would give a
/// size between a fifth of the block's smallest side and the block, and a size to fit to.
/// Below 2 mm they may give up to 200 mm, with a larger block: a block that was made for
/// a size in doubt does not decide about the unit.
std::optional<SizeFault> FindSizeFault(const SizeInBlock& model,
                                       std::string_view model_name);

}  // namespace intaglio::mesh
