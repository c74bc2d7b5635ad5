#pragma once

// Messages of the lines as the payload of a frame (frame.h), and back. Which messages
// there are: laser_protocol.h, motion_protocol.h, scan_head_protocol.h.

#include <cstddef>
#include <span>
#include <vector>

#include "engrave/core/result.h"

namespace intaglio::link {

using Bytes = std::vector<std::byte>;

template <typename Message>
Bytes Encode(const Message& message);

/// kUnreadable when the payload is shorter, longer or out of range.
template <typename Message>
Result<Message> Decode(std::span<const std::byte> payload);

}  // namespace intaglio::link
