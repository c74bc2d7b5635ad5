#pragma once

// A machine on a bench: both lines in memory, a host at each, one clock that the test
// moves.

#include <gtest/gtest.h>

#include <algorithm>
#include <deque>
#include <memory>
#include <string>
#include <vector>

#include "services/virtual_engraver/machine.h"
#include "tests/integration/run_program.h"
#include "tests/test_folder.h"

namespace intaglio::virtual_engraver {

/// One end of a line in memory. A cut line swallows what is written.
class BenchLine : public link::ByteStream {
 public:
  struct Wire {
    std::deque<std::byte> bytes;
    bool cut = false;
  };
  BenchLine(std::shared_ptr<Wire> in, std::shared_ptr<Wire> out)
      : in_(std::move(in)), out_(std::move(out)) {}

  Result<std::size_t> Read(std::span<std::byte> buffer) override {
    const std::size_t count = std::min(buffer.size(), in_->bytes.size());
    const auto end = in_->bytes.begin() + static_cast<std::ptrdiff_t>(count);
    std::copy(in_->bytes.begin(), end, buffer.begin());
    in_->bytes.erase(in_->bytes.begin(), end);
    return count;
  }
  Result<std::size_t> Write(std::span<const std::byte> bytes) override {
    if (!out_->cut) out_->bytes.insert(out_->bytes.end(), bytes.begin(), bytes.end());
    return bytes.size();
  }
  int fd() const override { return -1; }

 private:
  std::shared_ptr<Wire> in_, out_;
};

/// The machine's messages on both lines, decoded.
struct Received {
  std::vector<link::LaserIdentity> laser_identities;
  std::vector<link::LaserStatus> laser_statuses;
  std::vector<link::PulseReport> reports;
  std::vector<link::MotionIdentity> motion_identities;
  std::vector<link::MotionStatus> motion_statuses;
  std::vector<link::Positions> positions;

  void Receive(std::uint8_t type, std::span<const std::byte> payload) {
    Keep(type, link::LaserFrame::kLaserIdentity, payload, laser_identities);
    Keep(type, link::LaserFrame::kLaserStatus, payload, laser_statuses);
    Keep(type, link::LaserFrame::kPulseReport, payload, reports);
    Keep(type, link::MotionFrame::kMotionIdentity, payload, motion_identities);
    Keep(type, link::MotionFrame::kMotionStatus, payload, motion_statuses);
    Keep(type, link::MotionFrame::kPositions, payload, positions);
  }
  std::uint64_t fired_count() const {
    std::uint64_t count = 0;
    for (const auto& report : reports) {
      count += static_cast<std::uint64_t>(std::count_if(
          report.outcome.begin(), report.outcome.end(), [](link::TickOutcome outcome) {
            return outcome == link::TickOutcome::kFiredSeen ||
                   outcome == link::TickOutcome::kFiredUnseen;
          }));
    }
    return count;
  }

 private:
  template <typename Frame, typename T>
  static void Keep(std::uint8_t type, Frame frame, std::span<const std::byte> payload,
                   std::vector<T>& into) {
    if (type != static_cast<std::uint8_t>(frame)) return;
    auto decoded = link::Decode<T>(payload);
    ASSERT_TRUE(decoded.has_value());
    into.push_back(std::move(*decoded));
  }
};

class MachineBench : public ::testing::Test {
 protected:
  /// Warm at once; 100 Hz; no lag.
  static MachineOptions PlainOptions(bool lockstep) {
    MachineOptions options;
    options.stage.mechanics.lag_s = 0;
    options.stage.waits_for_motion = options.laser.lockstep = lockstep;
    options.laser.warm_up_s = 0;
    options.laser.min_energy_mj = 0;  // windows without an energy fire
    return options;
  }

  void Start(const MachineOptions& options) {
    record_file = test::FreshFolder() / "glass.rec";
    auto glass = Glass::Create(record_file, {options.block.size_mm, 1.5, 0.1});
    ASSERT_TRUE(glass.has_value());
    machine = std::make_unique<Machine>(options, std::move(*glass), clock);
    PlugLaser();
    PlugMotion();
  }
  void PlugLaser() {
    laser_in = std::make_shared<BenchLine::Wire>();
    auto out = std::make_shared<BenchLine::Wire>();
    machine->PlugLaserLine(std::make_unique<BenchLine>(laser_in, out));
    laser_host = std::make_unique<link::ReliableLink>(
        link::Side::kHost, std::make_unique<BenchLine>(out, laser_in), clock,
        link::LinkOptions{}, laser_epoch);
  }
  void PlugMotion() {
    motion_in = std::make_shared<BenchLine::Wire>();
    auto out = std::make_shared<BenchLine::Wire>();
    machine->PlugMotionLine(std::make_unique<BenchLine>(motion_in, out));
    motion_host = std::make_unique<link::ReliableLink>(
        link::Side::kHost, std::make_unique<BenchLine>(out, motion_in), clock);
  }

  void Pass(std::chrono::milliseconds time) {
    for (std::int64_t i = 0; i < time.count(); ++i) {
      now += std::chrono::milliseconds(1);
      const auto take = [this](std::uint8_t type, std::span<const std::byte> payload) {
        received.Receive(type, payload);
      };
      for (auto* host : {laser_host.get(), motion_host.get()}) {
        if (host != nullptr && !host->Poll(take)) ADD_FAILURE() << "the line is lost";
      }
      machine->Turn();
    }
  }
  void Connect() {
    Pass(std::chrono::milliseconds(10));
    ASSERT_TRUE(laser_host->up());
    ASSERT_TRUE(motion_host->up());
  }
  void SendLaser(link::LaserFrame type, const link::Bytes& payload = {}) {
    while (!laser_host->CanSend()) Pass(std::chrono::milliseconds(1));
    ASSERT_TRUE(laser_host->Send(static_cast<std::uint8_t>(type), payload).has_value());
  }
  void SendMotion(link::MotionFrame type, const link::Bytes& payload = {}) {
    while (!motion_host->CanSend()) Pass(std::chrono::milliseconds(1));
    ASSERT_TRUE(motion_host->Send(static_cast<std::uint8_t>(type), payload).has_value());
  }
  void OpenShutterAndLamp() {
    SendLaser(link::LaserFrame::kLampCommand, Encode(link::LampCommand{true, 100}));
    SendLaser(link::LaserFrame::kShutterCommand, Encode(link::ShutterCommand{1}));
  }
  std::vector<formats::GlassCrack> Cracks() {
    EXPECT_TRUE(machine->glass().Flush().has_value());
    return formats::ReadGlassRecord(record_file)->cracks;
  }

  // Not from zero: a machine is rarely as old as its clock.
  std::chrono::nanoseconds now = std::chrono::hours(3);
  link::SteadyClock clock = [this] { return now; };
  std::filesystem::path record_file;
  std::unique_ptr<Machine> machine;
  std::unique_ptr<link::ReliableLink> laser_host, motion_host;
  std::shared_ptr<BenchLine::Wire> laser_in, motion_in;  // towards the machine
  std::shared_ptr<link::LineEpoch> laser_epoch = std::make_shared<link::LineEpoch>();
  Received received;
};

}  // namespace intaglio::virtual_engraver
