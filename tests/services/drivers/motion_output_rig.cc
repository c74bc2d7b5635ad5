#include "tests/services/drivers/motion_output_rig.h"

#include <algorithm>

#include "services/drivers/laser_drivers.h"

namespace intaglio::drivers {

/// Closing one end is seen at the other, as of a socket.
class MotionOutputRig::Ends final : public link::ByteStream {
 public:
  Ends(std::shared_ptr<link::FaultyPipe> in, std::shared_ptr<link::FaultyPipe> out,
       std::shared_ptr<std::mt19937_64> random, link::SteadyClock clock)
      : in_(in), out_(out), end_(in, out, std::move(random), std::move(clock)) {}
  ~Ends() override { in_->gone = out_->gone = true; }
  Result<std::size_t> Read(std::span<std::byte> buffer) override {
    return end_.Read(buffer);
  }
  Result<std::size_t> Write(std::span<const std::byte> bytes) override {
    return end_.Write(bytes);
  }
  int fd() const override { return -1; }

 private:
  std::shared_ptr<link::FaultyPipe> in_, out_;
  link::FaultyEnd end_;
};

MotionOutputRig::MotionOutputRig(std::unique_ptr<LaserRig> inner, CutLineOf cut_line,
                                 const std::string& serial_number)
    : inner_(std::move(inner)), cut_line_(cut_line), serial_number_(serial_number) {
  output_ = std::make_unique<LaserOutput>(*inner_->driver, [this] { return now_; });
  NewHost();
}

void MotionOutputRig::NewHost() {
  driver.reset();
  MachineSpec profile;
  profile.set_name("els-03");
  profile.mutable_laser_line()->set_device("unix:/the/socket");
  if (!serial_number_.empty())
    profile.mutable_laser_line()->set_serial_number(serial_number_);
  for (const LaserDriverKind& kind : LaserDriverKinds()) {
    if (kind.protocol != kMotionOutput) continue;
    driver = kind.make(
        profile,
        [this]() -> Result<std::unique_ptr<link::ByteStream>> {
          if (!output_->ready() || output_->has_host())
            return Fail(ErrorCode::kLinkLost, "closed without an answer; check the line");
          return Open();
        },
        [this] { return now_; });
  }
}

std::unique_ptr<link::ByteStream> MotionOutputRig::Open() {
  const bool cut = to_bridge_->cut;
  to_bridge_ = std::make_shared<link::FaultyPipe>();
  to_host_ = std::make_shared<link::FaultyPipe>();
  to_bridge_->cut = to_host_->cut = cut;
  const auto clock = [this] { return now_; };
  output_->Plug(std::make_unique<Ends>(to_bridge_, to_host_, random_, clock));
  return std::make_unique<Ends>(to_host_, to_bridge_, random_, clock);
}

void MotionOutputRig::AdvanceController() {
  now_ += std::chrono::milliseconds(1);
  inner_->Advance();
  output_->Poll();
  if (to_bridge_->cut) to_host_->cut = true;
}

void MotionOutputRig::CutLine(bool cut) {
  if (cut_line_ == CutLineOf::kController) return inner_->CutLine(cut);
  to_bridge_->cut = to_host_->cut = cut;
  to_bridge_->cut_after = UINT64_MAX;
}

void MotionOutputRig::CutLineAfter(std::uint64_t bytes) {
  if (cut_line_ == CutLineOf::kController) return inner_->CutLineAfter(bytes);
  to_bridge_->cut_after = to_bridge_->taken_count + bytes;
}

void MotionOutputRig::KillBridge() {
  to_bridge_->gone = to_host_->gone = true;
  output_.reset();
  output_ = std::make_unique<LaserOutput>(*inner_->driver, [this] { return now_; });
}

void MotionOutputRig::KillSynchronizer() { NewHost(); }

}  // namespace intaglio::drivers
