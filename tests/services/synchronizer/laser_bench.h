#pragma once

// A drivers::LaserController at a fake laser, on a line in memory and a clock that the
// test moves by 1 ms at a time; and a journal in a file of its own. For the parts of
// Engraving that are tested alone.

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <memory>
#include <random>
#include <thread>
#include <vector>

#include "proto/machine.pb.h"
#include "services/cell/journal_writer.h"
#include "services/drivers/virtual/virtual_laser_driver.h"
#include "services/synchronizer/pulses/cell_names.h"
#include "tests/services/platform/link/faulty_line.h"
#include "tests/services/synchronizer/fake_laser.h"

namespace intaglio::synchronizer {

class LaserBench {
 public:
  explicit LaserBench(bool lockstep = false)
      : laser([this] { return now; }, lockstep),
        driver(drivers::MakeVirtualLaserDriver(
            MachineSpec(),
            [this] {
              return Result<std::unique_ptr<link::ByteStream>>(
                  LineEnd(to_host_, to_laser_));
            },
            [this] { return now; })),
        controller(*driver) {
    laser.Plug(LineEnd(to_laser_, to_host_));
    StepFor(std::chrono::milliseconds(600));
  }

  /// One millisecond; no tick passes.
  void Step() {
    now += std::chrono::milliseconds(1);
    laser.Poll();
    controller.Poll([this](const link::PulseReport& r) { reports.push_back(r); },
                    [this](const link::PastReport& r) { pasts.push_back(r); });
  }
  void StepFor(std::chrono::milliseconds time) {
    for (const auto end = now + time; now < end;) Step();
  }
  void PassTicks(int count) {
    for (int i = 0; i < count; ++i) laser.AdvanceTick(true, Vec3::Zero());
  }
  /// Lamp on and warm, known to the controller.
  void WarmUp() {
    (void)controller.Lamp(true, FakeLaser::kRateHz);
    StepFor(std::chrono::milliseconds(10));
    PassTicks(30);
    StepFor(std::chrono::milliseconds(30));
  }
  void CutLine(bool cut) { to_laser_->cut = to_host_->cut = cut; }
  /// Long enough for a new session.
  void Reconnect() {
    CutLine(true);
    StepFor(std::chrono::milliseconds(600));
    CutLine(false);
    StepFor(std::chrono::milliseconds(600));
  }
  void PowerCycle() {
    CutLine(true);
    StepFor(std::chrono::milliseconds(600));
    CutLine(false);
    laser.PowerCycle(LineEnd(to_laser_, to_host_));
    StepFor(std::chrono::milliseconds(600));
  }
  std::size_t ReceivedCount(link::LaserFrame type) const {
    return static_cast<std::size_t>(
        std::count(laser.received.begin(), laser.received.end(), type));
  }

  std::chrono::nanoseconds now = std::chrono::seconds(1);

 private:
  std::unique_ptr<link::ByteStream> LineEnd(std::shared_ptr<link::FaultyPipe> in,
                                            std::shared_ptr<link::FaultyPipe> out) {
    return std::make_unique<link::FaultyEnd>(std::move(in), std::move(out), random_,
                                             [this] { return now; });
  }
  std::shared_ptr<std::mt19937_64> random_ = std::make_shared<std::mt19937_64>(1);
  std::shared_ptr<link::FaultyPipe> to_laser_ = std::make_shared<link::FaultyPipe>();
  std::shared_ptr<link::FaultyPipe> to_host_ = std::make_shared<link::FaultyPipe>();

 public:
  FakeLaser laser;
  std::unique_ptr<drivers::LaserController> driver;
  drivers::LaserController& controller;
  std::vector<link::PulseReport> reports;
  std::vector<link::PastReport> pasts;
};

/// A journal of its own in the test's folder; it is gone with this.
class JournalBench {
 public:
  explicit JournalBench(std::uint64_t point_count)
      : file(std::filesystem::path(testing::TempDir()) /
             fmt::format("journal-bench-{}-{}.bin", getpid(), NextNumber())),
        writer(*JournalWriter::Create(file, {point_count, 1, 7})) {}
  ~JournalBench() {
    writer.reset();
    std::error_code ignored;
    std::filesystem::remove(file, ignored);
  }
  /// Waits for the journal's thread.
  formats::Journal OnDisk() const {
    AwaitDisk();
    return *formats::ReadJournal(file);
  }
  void AwaitDisk() const {
    writer->Flush();
    while (writer->durable() < writer->appended()) std::this_thread::yield();
  }
  /// Until it takes no more; nothing of it reaches the disk before AwaitDisk.
  void Fill() const {
    while (writer->Append({formats::JournalKind::kSession})) {
    }
  }

  std::filesystem::path file;
  std::unique_ptr<JournalWriter> writer;

 private:
  static int NextNumber() {
    static int number = 0;
    return ++number;
  }
};

}  // namespace intaglio::synchronizer
