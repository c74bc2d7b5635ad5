#pragma once

// The supplied HAL files alone, without any driver: rows and commands are written by
// halstreamer, and halsampler shows what the axes and the laser do.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <functional>
#include <memory>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "tests/services/drivers/linuxcnc/hal_machine.h"
#include "tests/test_folder.h"

namespace intaglio::linuxcnc {

using std::chrono::milliseconds;

struct Row {
  int tick = 1, number = 0, arm = 7, motion = 3, fire = 0, gated = 0;
  double x_mm = 0;
  int again_off = 0;
};

struct Sample {
  long period = 0, tick = 0, number = 0, command = 0, flags = 0, pulses = 0, openings = 0;
  double x_mm = 0, target_x_mm = 0;
  bool fresh() const { return (flags & 1) != 0; }
  bool laser() const { return (flags & 4) != 0; }
  bool laser_ok() const { return (flags & 128) != 0; }
};

inline Sample Parse(const std::string& line) {
  std::istringstream in(line);
  double number = 0, row_arm = 0, command = 0, arm = 0, motion = 0, y = 0, z = 0, ty = 0,
         tz = 0;
  long key = 0, door = 0, stop = 0;
  Sample s;
  in >> s.period >> s.tick >> number >> row_arm >> command >> arm >> motion >> s.flags >>
      s.x_mm >> y >> z >> s.target_x_mm >> ty >> tz >> s.pulses >> key >> door >> stop;
  s.number = std::lround(number);
  s.command = std::lround(command);
  s.openings = key + door + stop;
  return s;
}

class HalConfiguration : public ::testing::Test {
 protected:
  void SetUp() override {
    if (const std::string why = EnterNamespace(); !why.empty()) GTEST_SKIP() << why;
    machine_ = std::make_unique<HalMachine>(test::FreshFolder(), "",
                                            std::filesystem::path(), has_beam());
    samples_ =
        test::FreshFolder("hal_samples_" + machine_->folder().filename().string()) /
        "samples";
    const std::string none = "/dev/null";
    rows_ = std::make_unique<HalTool>(std::vector<std::string>{"halstreamer", "-c", "0"},
                                      none);
    commands_ = std::make_unique<HalTool>(
        std::vector<std::string>{"halstreamer", "-c", "1"}, none);
    sampler_ = std::make_unique<HalTool>(
        std::vector<std::string>{"stdbuf", "-oL", "halsampler", "-c", "0", "-t"},
        samples_);
    Send(0), Send(1);
    wake_ = true, Send(0), wake_ = false;
    for (int i = 0; i < 4; ++i) Send(i % 2);
    lamp_ = shutter_ = true;
    reset_ = true, Send(0), reset_ = false;
    Await([this](const Sample& s) {
      return s.laser_ok() && (has_beam() || (s.flags & 512) != 0);
    });
  }
  virtual bool has_beam() const { return false; }
  void Send(int heartbeat) {
    ++command_;
    const std::string line =
        fmt::format("{} {} {} {} {} {} {} {} {} {} 10 {}\n", command_, arm_, 3, heartbeat,
                    stop_ ? 1 : 0, wake_ ? 1 : 0, reset_ ? 1 : 0, reset_ ? 1 : 0,
                    shutter_ ? 1 : 0, lamp_ ? 1 : 0, command_ + command_off_);
    commands_->Write(line);
  }
  /// One heartbeat a period, all of them sent at once: so that they are in time however
  /// late this process is.
  void Beat(milliseconds time) {
    const auto end = std::chrono::steady_clock::now() + time;
    for (std::int64_t i = 0; i < time.count(); ++i) Send(i % 2 == 0 ? 0 : 1);
    std::this_thread::sleep_until(end);
  }
  void Write(Row row) {
    row.number = ++number_;
    const std::string line = fmt::format("{} {} {} {} {} {} {:.6f} 0 0 {}\n", row.tick,
                                         row.number, row.arm, row.motion, row.fire,
                                         row.gated, row.x_mm, row.number + row.again_off);
    rows_->Write(line);
  }
  /// Beats until a sample is so; fails after 10 s.
  void Await(const std::function<bool(const Sample&)>& condition) {
    for (int i = 0; i < 200; ++i) {
      const auto samples = Samples();
      if (!samples.empty() && condition(samples.back())) return;
      Beat(milliseconds(50));
    }
    ADD_FAILURE() << "HAL does not report it";
  }
  void AwaitCommands() {
    Send(0);
    Await([number = command_](const Sample& s) { return s.command >= number; });
  }
  /// All of them, after all commands; until they have been played, and a little more.
  void Play(const std::vector<Row>& rows, bool beats = true) {
    AwaitCommands();
    // As many in advance: this process may be late.
    for (std::size_t i = 0; beats && i < rows.size() + 500; ++i) Send(i % 2 == 0 ? 0 : 1);
    for (const Row& row : rows) Write(row);
    if (!beats) std::this_thread::sleep_for(milliseconds(rows.size() + 300));
    Await([number = number_](const Sample& s) { return s.number >= number; });
    Beat(milliseconds(50));
    AwaitCommands();
  }
  std::vector<Sample> Samples() const {
    std::istringstream in(test::ContentOf(samples_));
    std::vector<Sample> all;
    for (std::string line; std::getline(in, line);) {
      if (std::isdigit(line[0]) != 0 && !in.eof()) all.push_back(Parse(line));
    }
    return all;
  }
  long LaserPeriods() const {
    long count = 0;
    for (const Sample& s : Samples()) count += s.laser() ? 1 : 0;
    return count;
  }

  std::unique_ptr<HalMachine> machine_;
  std::filesystem::path samples_;
  std::unique_ptr<HalTool> rows_, commands_, sampler_;
  int number_ = 0, command_ = 0, arm_ = 7, command_off_ = 0;
  bool stop_ = false, wake_ = false, reset_ = false, shutter_ = false, lamp_ = false;
};

}  // namespace intaglio::linuxcnc
