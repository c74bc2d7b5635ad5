#include "services/drivers/virtual/virtual_stage_driver.h"

#include <fmt/format.h>

#include <algorithm>
#include <deque>
#include <limits>
#include <optional>

#include "services/drivers/virtual/stage_wire.h"
#include "services/job/checks/stage_speed_check.h"
#include "services/platform/link/expected_device.h"

namespace intaglio::drivers {
namespace {

using link::MotionFrame;
using wire::ToMm;
using wire::ToNm;

// The controller sends its status within this time, and its line is kept alive by the
// acknowledgement, at least every 50 ms (LinkOptions::keep_alive).
constexpr std::chrono::milliseconds kStatusWait{45};

class VirtualStageDriver final : public MotionDriver {
 public:
  VirtualStageDriver(link::FramePort port, link::ExpectedDevice expected,
                     const MachineSpec& machine)
      : expected_(std::move(expected)),
        machine_(machine),
        needs_block_(machine.head_over_block().has_block_stage()),
        session_(std::move(port)) {}

  void Poll() override {
    session_.Poll([this](std::uint8_t type, std::span<const std::byte> payload) {
      Handle(static_cast<MotionFrame>(type), payload);
    });
    if (session_.sessions() != polled_sessions_) {
      polled_sessions_ = session_.sessions();
      identified_ = identified_now_;
      if (!refused_now_) state_.refusal.clear();
    }
    identified_now_ = refused_now_ = false;
    if (!session_.up()) {
      identified_ = false;
      state_.refusal.clear();
      state_.taken_over = session_.fenced();
      return SetDown(intaglio_MOTION_LINK_LOST, "motion line: " + session_.message());
    }
    if (!state_.refusal.empty())
      return SetDown(intaglio_MOTION_WRONG_CONTROLLER, state_.refusal);
    state_.link_up = identified_;
  }

  int fd() const override { return session_.fd(); }
  std::chrono::milliseconds resting_wait() const override { return kStatusWait; }
  const DriverState& state() const override { return state_; }
  std::vector<LatchedPositions> TakePositions() override {
    return std::exchange(positions_, {});
  }

  Status BeginRun(std::uint32_t run, std::uint64_t start_tick,
                  std::uint64_t start_ns) override {
    const std::int32_t x_nm = ToNm(block_mm_.x()), y_nm = ToNm(block_mm_.y());
    auto sent = start_ns == 0
                    ? SendFrame(MotionFrame::kBeginRun,
                                Encode(link::BeginRun{run, start_tick, x_nm, y_nm}))
                    : SendFrame(MotionFrame::kBeginTimedRun,
                                Encode(link::BeginTimedRun{run, start_ns, x_nm, y_nm}));
    if (sent) {
      begun_run_ = run;
      appended_ = 0;
      covered_.Begin(start_tick);
    }
    return sent;
  }

  Status RequireBlockAt(const Vec2& place_mm) override {
    if (!needs_block_) return MotionDriver::RequireBlockAt(place_mm);
    block_mm_ = place_mm;
    return {};
  }

  std::size_t Room() const override {
    if (!state_.link_up || !session_.CanSend()) return 0;
    // The last status speaks of the run before, or of segments it has not seen yet.
    const bool same_run = status_.run == begun_run_;
    const std::uint64_t unseen = appended_ - (same_run ? status_.segments_taken : 0);
    if (status_.queue_free <= unseen) return 0;
    return std::min<std::size_t>(
        status_.queue_free - unseen,
        state_.clock != 0 ? link::kMaxTimedSegments : link::kMaxSegments);
  }

  Status Append(std::span<const motion::Segment> segments,
                std::span<const std::uint64_t> end_ns) override {
    auto sent =
        end_ns.empty() ? SendSegments(segments) : SendTimedSegments(segments, end_ns);
    if (!sent) return sent;
    appended_ += segments.size();
    if (!end_ns.empty()) covered_.Append(segments);
    // A fresh status frees the queue's room here and reports how far the motion reaches.
    if (session_.CanSend()) (void)SendFrame(MotionFrame::kMotionStatusRequest, {});
    return {};
  }

  Status AbortRun() override { return SendFrame(MotionFrame::kAbortRun, {}); }
  Status Jog(const Vec3& axes, double speed_mm_s) override {
    if (!state_.homed) return Fail(ErrorCode::kRefused, WhyPlaceIsUnknown(state_));
    return SendJog(MotionFrame::kJogMove, Encode(wire::ToJogMove(axes, speed_mm_s)));
  }
  Status Home() override { return SendJog(MotionFrame::kHome, {}); }
  Status MoveBlock(const Vec2& place_mm, double speed_mm_s) override {
    if (!needs_block_) return HandMotion::MoveBlock(place_mm, speed_mm_s);
    return SendJog(MotionFrame::kMoveBlock,
                   Encode(wire::ToMoveBlock(place_mm, speed_mm_s)));
  }
  Status ClearFault() override { return SendFrame(MotionFrame::kMotionReset, {}); }

 private:
  /// How far in ticks the motion reaches that a clock of its own counts in ns.
  class Coverage {
   public:
    void Begin(std::uint64_t start_tick) {
      start_tick_ = start_tick;
      through_subticks_.clear();
      first_ = sum_ = taken_sum_ = 0;
    }
    void Append(std::span<const motion::Segment> segments) {
      for (const motion::Segment& segment : segments) {
        through_subticks_.push_back(sum_ += segment.duration_subticks);
      }
    }
    std::uint64_t TickAfter(std::uint64_t segments_taken) {
      for (; first_ < segments_taken && !through_subticks_.empty(); ++first_) {
        taken_sum_ = through_subticks_.front();
        through_subticks_.pop_front();
      }
      return start_tick_ + taken_sum_ / motion::kSubticksPerTick;
    }

   private:
    std::uint64_t start_tick_ = 0, first_ = 0, sum_ = 0, taken_sum_ = 0;
    std::deque<std::uint64_t> through_subticks_;  // of each segment not taken yet
  };

  Status SendSegments(std::span<const motion::Segment> segments) {
    link::Segments frame{begun_run_, appended_, {}};
    frame.segments.reserve(segments.size());
    for (const motion::Segment& segment : segments) {
      const auto on_line = wire::ToWire(segment, velocity_unit_nm_s_);
      if (!on_line) return RefuseVelocity(segment);
      frame.segments.push_back(*on_line);
    }
    return SendFrame(MotionFrame::kSegments, Encode(frame));
  }
  Status SendTimedSegments(std::span<const motion::Segment> segments,
                           std::span<const std::uint64_t> end_ns) {
    link::TimedSegments frame{begun_run_, appended_, {}};
    frame.segments.reserve(segments.size());
    for (std::size_t i = 0; i < segments.size(); ++i) {
      const auto on_line = wire::ToWire(segments[i], velocity_unit_nm_s_);
      if (!on_line) return RefuseVelocity(segments[i]);
      frame.segments.push_back(wire::Timed(*on_line, end_ns[i]));
    }
    return SendFrame(MotionFrame::kTimedSegments, Encode(frame));
  }
  /// Another velocity than the planned one would be another path.
  Status RefuseVelocity(const motion::Segment& segment) {
    Refuse(fmt::format(
        "the plan needs a velocity of {:.6g} mm/s, and {:.6g} mm/s is the largest that "
        "the "
        "stage controller takes on its line: reduce max_speed_mm_s of the axes in the "
        "machine profile",
        segment.end_velocity_mm_s.cwiseAbs().maxCoeff(),
        std::numeric_limits<std::int32_t>::max() / wire::kNmPerMm * velocity_unit_nm_s_));
    return Fail(ErrorCode::kRefused, state_.refusal);
  }
  void SetDown(intaglio_MotionFault fault, const std::string& message) {
    if (state_.link_up || state_.message != message) ++state_.number;
    state_.link_up = false;
    state_.clock = 0;
    state_.fault = fault;
    state_.message = message;
  }
  Status SendJog(MotionFrame type, const link::Bytes& payload) {
    if (!identified_) return Fail(ErrorCode::kLinkLost, state_.message);
    if (!state_.at_rest || state_.fault != intaglio_MOTION_OK) {
      return Fail(ErrorCode::kRefused,
                  state_.at_rest ? state_.message : "the stage is not at rest");
    }
    auto sent = SendFrame(type, payload);
    if (!sent) return sent;
    ++jogs_sent_;
    state_.at_rest = false;  // until a status that counts this one says so
    return sent;
  }
  Status SendFrame(MotionFrame type, const link::Bytes& payload) {
    if (!identified_) return Fail(ErrorCode::kLinkLost, state_.message);
    return session_.Send(static_cast<std::uint8_t>(type), payload);
  }

  void Handle(MotionFrame type, std::span<const std::byte> payload) {
    if (type == MotionFrame::kMotionIdentity) return Identify(payload);
    if (!identified_) return;
    if (type == MotionFrame::kMotionStatus) {
      if (const auto status = link::Decode<link::MotionStatus>(payload)) Receive(*status);
    } else if (type == MotionFrame::kControllerClock) {
      const auto clock = link::Decode<link::ControllerClock>(payload);
      if (clock) state_.clock = clock->power_up;
    } else if (type == MotionFrame::kStageSpeed) {
      if (const auto speed = link::Decode<link::StageSpeed>(payload)) Compare(*speed);
    } else if (type == MotionFrame::kStageTolerance) {
      const auto tolerance = link::Decode<link::StageTolerance>(payload);
      if (tolerance) state_.position_tolerance_um = tolerance->position_nm / 1e3;
    } else if (type == MotionFrame::kTimedPositions) {
      if (const auto latched = link::Decode<link::TimedPositions>(payload)) {
        LatchedPositions entry{latched->run, latched->first_tick, {}, {}};
        for (const auto& p : latched->positions) {
          entry.positions_mm.push_back(ToMm(p.x_nm, p.y_nm, p.z_nm));
          entry.at_ns.push_back(p.at_ns);
        }
        positions_.push_back(std::move(entry));
      }
    } else if (type == MotionFrame::kPositions) {
      if (const auto latched = link::Decode<link::Positions>(payload)) {
        LatchedPositions entry{latched->run, latched->first_tick, {}, {}};
        for (const auto& p : latched->positions) {
          entry.positions_mm.push_back(ToMm(p.x_nm, p.y_nm, p.z_nm));
        }
        positions_.push_back(std::move(entry));
      }
    }
  }

  void Identify(std::span<const std::byte> payload) {
    const auto identity = link::Decode<link::MotionIdentity>(payload);
    if (!identity)
      return Refuse(identity.error().message + ": " + expected_.VersionHint());
    if (auto why = link::RefusalOf(expected_, identity->serial_number); !why.empty())
      return Refuse(std::move(why));
    if (machine_.pulse_trigger() == PULSE_TRIGGER_AT_PLACE && !identity->compares_place) {
      return Refuse(
          "the stage controller has no compare output: set pulse_trigger in the machine "
          "profile to PULSE_TRIGGER_AT_TICK");
    }
    if (machine_.compressed_air() && !identity->watches_air) {
      return Refuse(
          "the stage controller watches no compressed air: connect its pressure switch, "
          "or remove compressed_air from the machine profile");
    }
    if (needs_block_ && !identity->moves_block) {
      return Refuse(
          "the stage controller moves no stage that carries the block: connect that "
          "stage "
          "to it, or remove head_over_block.block_stage from the machine profile");
    }
    state_.refusal.clear();
    state_.has_block_stage = identity->moves_block;
    velocity_unit_nm_s_ = identity->velocity_unit_nm_s;
    identified_ = identified_now_ = true;
    state_.position_tolerance_um = 0;  // it will report one when it knows it
    status_.queue_free = 0;            // until its first status
    first_status_ = true;
    state_.clock = 0;  // it will announce one when it has one
    (void)SendFrame(MotionFrame::kMotionStatusRequest, {});
  }
  void Compare(const link::StageSpeed& speed) {
    const Vec3 max = velocity_unit_nm_s_ / wire::kNmPerMm *
                     Vec3(speed.x_counts, speed.y_counts, speed.z_counts);
    std::string faster;
    for (const Error& error : CompareStageSpeed(machine_, max))
      faster += (faster.empty() ? "" : "; ") + error.message;
    if (!faster.empty()) Refuse(std::move(faster));
  }
  void Refuse(std::string why) {
    state_.refusal = std::move(why);
    refused_now_ = true;
    identified_ = identified_now_ = false;
    positions_.clear();
    (void)session_.Send(static_cast<std::uint8_t>(MotionFrame::kAbortRun), {});
  }

  void Receive(const link::MotionStatus& status) {
    status_ = status;
    state_.link_up = identified_;
    state_.tick = status.tick;
    state_.position_mm = ToMm(status.x_nm, status.y_nm, status.z_nm);
    state_.velocity_mm_s =
        velocity_unit_nm_s_ * ToMm(status.vx_counts, status.vy_counts, status.vz_counts);
    state_.run = status.run;
    state_.covered_through_tick = status.covered_through_tick;
    if (state_.clock != 0 && status.run == begun_run_) {
      state_.covered_through_tick = covered_.TickAfter(status.segments_taken);
    }
    if (std::exchange(first_status_, false)) jogs_sent_ = status.jogs_taken;
    state_.block_mm = ToMm(status.block_x_nm, status.block_y_nm, 0).head<2>();
    state_.at_rest = status.at_rest && status.jogs_taken == jogs_sent_;
    state_.following_error_max_um = status.following_error_max_nm / 1e3;
    const wire::FaultText text = wire::TextOf(status.fault, status.fault_axes);
    state_.homed = !status.place_lost;
    state_.fault = text.fault;
    state_.message = text.message;
    ++state_.number;
  }

  link::ExpectedDevice expected_;
  MachineSpec machine_;
  bool needs_block_;
  link::FramePort session_;
  DriverState state_;
  link::MotionStatus status_;
  bool identified_ = false;
  bool identified_now_ = false, refused_now_ = false;  // in this Poll
  std::uint32_t polled_sessions_ = 0;
  std::uint32_t velocity_unit_nm_s_ = 1;  // as the controller reports
  std::uint32_t begun_run_ = 0;
  std::uint64_t appended_ = 0;
  bool first_status_ = true;      // of this session is still to come
  std::uint32_t jogs_sent_ = 0;   // motions by hand, as the controller counts them
  Vec2 block_mm_ = Vec2::Zero();  // where the next run needs the block
  Coverage covered_;
  std::vector<LatchedPositions> positions_;
};

}  // namespace

std::unique_ptr<MotionDriver> MakeVirtualStageDriver(const MachineSpec& machine,
                                                     link::StreamOpener open,
                                                     link::SteadyClock clock) {
  return MakeVirtualStageDriver(machine,
                                link::FramePort(std::move(open), std::move(clock)));
}

std::unique_ptr<MotionDriver> MakeVirtualStageDriver(const MachineSpec& machine,
                                                     link::FramePort port) {
  const SerialLine& line = machine.motion_line();
  return std::make_unique<VirtualStageDriver>(
      std::move(port),
      link::ExpectedDevice{line.serial_number(), "stage controller", machine.name(),
                           line.device(), "motion_line"},
      machine);
}

}  // namespace intaglio::drivers
