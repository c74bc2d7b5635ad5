#include "services/platform/link/motion_protocol.h"

#include "services/platform/link/message_fields.h"

namespace intaglio::link {
namespace {

constexpr std::size_t kMaxMotionSerialNumber = 64;

struct OnMotionLine {
  static constexpr const char* kLine = "motion line";
};

void Position(auto& io, auto& m) {
  io.Number(m.x_nm);
  io.Number(m.y_nm);
  io.Number(m.z_nm);
}

void Velocity(auto& io, auto& m) {
  io.Number(m.vx_counts);
  io.Number(m.vy_counts);
  io.Number(m.vz_counts);
}

void BlockPlace(auto& io, auto& m) {
  io.Number(m.block_x_nm);
  io.Number(m.block_y_nm);
}

/// The first segment of Segments and TimedSegments.
void FirstSegment(auto& io, auto& m, std::size_t max_count) {
  io.Number(m.run);
  io.Number(m.first_number);
  io.template Size<std::uint8_t>(m.segments, 1, max_count);
  io.Require(!GoesRound(m.first_number, m.segments.size()));
}

/// The first position of Positions and TimedPositions.
void FirstPosition(auto& io, auto& m, std::size_t max_count) {
  io.Number(m.run);
  io.Number(m.first_tick);
  io.template Size<std::uint8_t>(m.positions, 1, max_count);
  io.Require(!GoesRound(m.first_tick, m.positions.size()));
}

}  // namespace

template <>
struct Layout<BeginRun> : OnMotionLine {
  static constexpr const char* kName = "BeginRun";
  static void Fields(auto& io, auto& m) {
    io.Number(m.run);
    io.Number(m.start_tick);
    BlockPlace(io, m);
  }
};

template <>
struct Layout<Segments> : OnMotionLine {
  static constexpr const char* kName = "Segments";
  static void Fields(auto& io, auto& m) {
    FirstSegment(io, m, kMaxSegments);
    for (auto& segment : m.segments) {
      Position(io, segment);
      Velocity(io, segment);
      io.Number(segment.duration_subticks);
      io.Require(segment.duration_subticks > 0);
      io.Bits(segment.pulse, segment.program_end);
    }
  }
};

template <>
struct Layout<MotionIdentity> : OnMotionLine {
  static constexpr const char* kName = "MotionIdentity";
  static void Fields(auto& io, auto& m) {
    for (auto& limit_nm : m.travel_min_nm) io.Number(limit_nm);
    for (auto& limit_nm : m.travel_max_nm) io.Number(limit_nm);
    io.Number(m.queue_capacity);
    io.PrintableText(m.serial_number, kMaxMotionSerialNumber);
    io.Bits(m.compares_place, m.watches_air, m.moves_block);
    io.Number(m.velocity_unit_nm_s);
    io.Require(m.velocity_unit_nm_s > 0);
  }
};

template <>
struct Layout<MotionStatus> : OnMotionLine {
  static constexpr const char* kName = "MotionStatus";
  static void Fields(auto& io, auto& m) {
    io.Number(m.tick);
    Position(io, m);
    Velocity(io, m);
    io.Number(m.run);
    io.Number(m.covered_through_tick);
    io.Number(m.queue_free);
    io.Number(m.segments_taken);
    io.Bits(m.at_rest, m.place_lost, m.fault_axes[0], m.fault_axes[1], m.fault_axes[2]);
    io.Enumerator(m.fault, StageFault::kTooFast);
    io.Number(m.following_error_max_nm);
    io.Number(m.jogs_taken);
    BlockPlace(io, m);
  }
};

template <>
struct Layout<Positions> : OnMotionLine {
  static constexpr const char* kName = "Positions";
  static void Fields(auto& io, auto& m) {
    FirstPosition(io, m, kMaxPositions);
    for (auto& position : m.positions) Position(io, position);
  }
};

template <>
struct Layout<BeginTimedRun> : OnMotionLine {
  static constexpr const char* kName = "BeginTimedRun";
  static void Fields(auto& io, auto& m) {
    io.Number(m.run);
    io.Number(m.start_ns);
    BlockPlace(io, m);
  }
};

template <>
struct Layout<TimedSegments> : OnMotionLine {
  static constexpr const char* kName = "TimedSegments";
  static void Fields(auto& io, auto& m) {
    FirstSegment(io, m, kMaxTimedSegments);
    std::uint64_t before_ns = 0;
    for (auto& segment : m.segments) {
      Position(io, segment);
      Velocity(io, segment);
      io.Number(segment.end_ns);
      io.Require(segment.end_ns > before_ns);
      before_ns = segment.end_ns;
      io.Bits(segment.pulse, segment.program_end);
    }
  }
};

template <>
struct Layout<TimedPositions> : OnMotionLine {
  static constexpr const char* kName = "TimedPositions";
  static void Fields(auto& io, auto& m) {
    FirstPosition(io, m, kMaxTimedPositions);
    for (auto& position : m.positions) {
      io.Number(position.at_ns);
      Position(io, position);
    }
  }
};

template <>
struct Layout<ControllerClock> : OnMotionLine {
  static constexpr const char* kName = "ControllerClock";
  static void Fields(auto& io, auto& m) {
    io.Number(m.power_up);
    io.Require(m.power_up > 0);
    io.Number(m.now_ns);
  }
};

template <>
struct Layout<StageTolerance> : OnMotionLine {
  static constexpr const char* kName = "StageTolerance";
  static void Fields(auto& io, auto& m) {
    io.Number(m.position_nm);
    io.Require(m.position_nm > 0);
  }
};

template <>
struct Layout<StageSpeed> : OnMotionLine {
  static constexpr const char* kName = "StageSpeed";
  static void Fields(auto& io, auto& m) {
    io.Number(m.x_counts);
    io.Number(m.y_counts);
    io.Number(m.z_counts);
    io.Require(m.x_counts > 0 && m.y_counts > 0 && m.z_counts > 0);
  }
};

template <>
struct Layout<JogMove> : OnMotionLine {
  static constexpr const char* kName = "JogMove";
  static void Fields(auto& io, auto& m) {
    Position(io, m);
    io.Number(m.speed_nm_s);
    io.Require(m.speed_nm_s > 0);
  }
};

template <>
struct Layout<MoveBlock> : OnMotionLine {
  static constexpr const char* kName = "MoveBlock";
  static void Fields(auto& io, auto& m) {
    io.Number(m.x_nm);
    io.Number(m.y_nm);
    io.Number(m.speed_nm_s);
    io.Require(m.speed_nm_s > 0);
  }
};

template Bytes Encode(const BeginRun&);
template Bytes Encode(const Segments&);
template Bytes Encode(const MotionIdentity&);
template Bytes Encode(const MotionStatus&);
template Bytes Encode(const Positions&);
template Bytes Encode(const BeginTimedRun&);
template Bytes Encode(const TimedSegments&);
template Bytes Encode(const TimedPositions&);
template Bytes Encode(const ControllerClock&);
template Bytes Encode(const StageTolerance&);
template Bytes Encode(const StageSpeed&);
template Bytes Encode(const JogMove&);
template Bytes Encode(const MoveBlock&);
template Result<BeginRun> Decode(std::span<const std::byte>);
template Result<Segments> Decode(std::span<const std::byte>);
template Result<MotionIdentity> Decode(std::span<const std::byte>);
template Result<MotionStatus> Decode(std::span<const std::byte>);
template Result<Positions> Decode(std::span<const std::byte>);
template Result<BeginTimedRun> Decode(std::span<const std::byte>);
template Result<TimedSegments> Decode(std::span<const std::byte>);
template Result<TimedPositions> Decode(std::span<const std::byte>);
template Result<ControllerClock> Decode(std::span<const std::byte>);
template Result<StageTolerance> Decode(std::span<const std::byte>);
template Result<StageSpeed> Decode(std::span<const std::byte>);
template Result<JogMove> Decode(std::span<const std::byte>);
template Result<MoveBlock> Decode(std::span<const std::byte>);

}  // namespace intaglio::link
