#pragma once

// The pictures of a preview: the views of an engraved block (engrave/render/views.h) with
// the figures of the preview beside them, as PNG.

#include <cstdint>
#include <string>
#include <vector>

#include "engrave/core/geometry.h"
#include "proto/preview.pb.h"

namespace intaglio::client {

/// Points: glass frame, mm.
std::vector<std::uint8_t> DrawPreview(const JobPreview& figures,
                                      const PointList& points_mm);
/// The block of one channel.
std::vector<std::uint8_t> DrawChannel(const JobPreview& figures,
                                      const ChannelPreview& channel,
                                      const PointList& points_mm);

}  // namespace intaglio::client
