#pragma once

// A whole virtual machine behind two lines in memory that a test cuts, with its mains
// switch, on a clock that the test moves by 1 ms at a time.

#include <filesystem>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "engrave/formats/glass_record.h"
#include "services/platform/link/endpoint.h"
#include "services/virtual_engraver/machine.h"
#include "tests/services/platform/link/faulty_line.h"
#include "tests/test_folder.h"

namespace intaglio::virtual_engraver {

class MachineRig {
 public:
  /// Both ways of a line.
  struct Line {
    std::shared_ptr<link::FaultyPipe> to_machine, to_host;

    void Renew() {
      if (to_machine) to_machine->gone = to_host->gone = true;
      to_machine = std::make_shared<link::FaultyPipe>();
      to_host = std::make_shared<link::FaultyPipe>();
    }
    void Cut(bool cut) {
      to_machine->cut = to_host->cut = cut;
      to_machine->cut_after = UINT64_MAX;
    }
    /// After so many bytes more to the machine nothing passes, either way.
    void CutAfter(std::uint64_t bytes) {
      to_machine->cut_after = to_machine->taken_count + bytes;
    }
  };

  /// With one line that is `laser`.
  explicit MachineRig(MachineOptions options, bool one_line = false)
      : laser_and_motion_(one_line),
        folder_(test::FreshFolder()),
        options_(std::move(options)) {
    SwitchOn();
  }
  MachineRig(const MachineRig&) = delete;
  MachineRig& operator=(const MachineRig&) = delete;

  void SwitchOff() {
    machine_.reset();
    laser.to_machine->gone = laser.to_host->gone = true;
    if (!laser_and_motion_) motion.to_machine->gone = motion.to_host->gone = true;
  }
  /// With another clock, other counters, and a glass record of its own.
  void SwitchOn() {
    ++options_.laser.power_up;
    record_ = folder_ / ("glass" + std::to_string(options_.laser.power_up) + ".rec");
    auto glass = Glass::Create(record_, {options_.block.size_mm, 1, 0.1});
    if (!glass) throw std::runtime_error(glass.error().message);
    machine_ = std::make_unique<Machine>(options_, std::move(*glass), clock());
    laser.Renew();
    if (laser_and_motion_)
      return machine_->PlugOneLine(End(laser.to_machine, laser.to_host));
    motion.Renew();
    machine_->PlugLaserLine(End(laser.to_machine, laser.to_host));
    machine_->PlugMotionLine(End(motion.to_machine, motion.to_host));
  }

  /// A millisecond of the machine.
  void Advance() {
    now_ += std::chrono::milliseconds(1);
    if (machine_) machine_->Turn();
    for (Line* line : {&laser, &motion}) {
      if (line->to_machine && line->to_machine->cut) line->to_host->cut = true;
    }
  }

  link::SteadyClock clock() {
    return [this] { return now_; };
  }
  link::StreamOpener Opener(Line& line) {
    return [this, &line]() -> Result<std::unique_ptr<link::ByteStream>> {
      if (!machine_) return Fail(ErrorCode::kIo, "no such device");
      return End(line.to_host, line.to_machine);
    };
  }
  Machine& machine() { return *machine_; }
  std::vector<formats::GlassCrack> Cracks() const {
    return formats::ReadGlassRecord(record_).value().cracks;
  }

  Line laser, motion;

 private:
  std::unique_ptr<link::ByteStream> End(std::shared_ptr<link::FaultyPipe> in,
                                        std::shared_ptr<link::FaultyPipe> out) {
    return std::make_unique<link::FaultyEnd>(std::move(in), std::move(out), random_,
                                             clock());
  }

  bool laser_and_motion_;
  std::filesystem::path folder_, record_;
  MachineOptions options_;
  std::chrono::nanoseconds now_ = std::chrono::hours(3);
  std::shared_ptr<std::mt19937_64> random_ = std::make_shared<std::mt19937_64>(1);
  std::unique_ptr<Machine> machine_;
};

}  // namespace intaglio::virtual_engraver
