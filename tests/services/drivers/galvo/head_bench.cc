#include "tests/services/drivers/galvo/head_bench.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>

namespace intaglio::drivers {

// Bytes that wait to be read, as in a pseudo-terminal.
constexpr std::size_t kCapacity = 4096;

struct HeadBench::Wire {
  std::deque<std::byte> to_head, to_host;
};

class HeadBench::End final : public link::ByteStream {
 public:
  End(std::shared_ptr<Wire> wire, bool host, const bool& cut)
      : wire_(std::move(wire)), host_(host), cut_(cut) {}
  Result<std::size_t> Read(std::span<std::byte> buffer) override {
    auto& from = host_ ? wire_->to_host : wire_->to_head;
    const std::size_t count = std::min(buffer.size(), from.size());
    std::copy_n(from.begin(), count, buffer.begin());
    from.erase(from.begin(), from.begin() + static_cast<std::ptrdiff_t>(count));
    return count;
  }
  Result<std::size_t> Write(std::span<const std::byte> bytes) override {
    auto& to = host_ ? wire_->to_head : wire_->to_host;
    if (cut_) return bytes.size();
    bytes = bytes.first(std::min(bytes.size(), kCapacity - to.size()));
    to.insert(to.end(), bytes.begin(), bytes.end());
    return bytes.size();
  }
  int fd() const override { return -1; }

 private:
  std::shared_ptr<Wire> wire_;
  bool host_;
  const bool& cut_;
};

MachineSpec HeadProfile() {
  MachineSpec machine;
  machine.set_name("galvo-1");
  ScanHead& head = *machine.mutable_scan_head();
  head.set_field_mm(100);
  head.set_jump_mm_s(5000);
  head.set_servo_lag_s(0.0002);
  machine.mutable_mark_line()->set_protocol("scan-head");
  machine.mutable_mark_line()->set_device("/dev/head");
  return machine;
}

virtual_engraver::HeadOptions HeadTruthOf(const MachineSpec& machine) {
  virtual_engraver::HeadOptions head;
  head.physics.field_mm = machine.scan_head().field_mm();
  head.physics.servo_lag_s = machine.scan_head().servo_lag_s();
  if (machine.scan_head().encoder_count_um() > 0)
    head.physics.encoder_count_mm = machine.scan_head().encoder_count_um() / 1e3;
  head.power_up = 77;
  return head;
}

mark::Mark CircleMark(const Vec2& centre_mm, double diameter_mm, double web_mm) {
  const Vec2 radius_mm(diameter_mm / 2, 0);
  mark::Mark mark;
  mark.closed = true;
  mark.web_mm = web_mm;
  mark.places = {{centre_mm + radius_mm, 1}, {centre_mm - radius_mm, 1}};
  return mark;
}

mark::Mark LineMark(const Vec2& from_mm, const Vec2& to_mm) {
  mark::Mark mark;
  mark.places = {{from_mm, 0}, {to_mm, 0}};
  return mark;
}

HeadBench::HeadBench(const MachineSpec& machine,
                     const virtual_engraver::HeadOptions& head)
    : profile_(machine), head_(head) {
  static int number = 0;
  record_ = std::filesystem::temp_directory_path() /
            ("head_bench_" + std::to_string(getpid()) + "_" + std::to_string(++number));
  MakeMachine();
  Restart();
}

void HeadBench::MakeMachine() {
  machine_ = virtual_engraver::HeadMachine::Make(head_, record_, [this] {
               return now_;
             }).value();
}

void HeadBench::SwitchOff() { machine_.reset(); }

void HeadBench::SwitchOn() {
  ++head_.power_up;
  MakeMachine();
  Plug();
}

void HeadBench::Plug() {
  wire_->to_head.clear();
  wire_->to_host.clear();
  machine_->Plug(std::make_unique<End>(wire_, false, cut_));
}

HeadBench::~HeadBench() { std::filesystem::remove(record_); }

std::unique_ptr<MarkDriver> HeadBench::NewDriver(const MachineSpec& profile) {
  wire_ = std::make_shared<Wire>();
  Plug();
  const auto open = [this, wire = wire_]() -> Result<std::unique_ptr<link::ByteStream>> {
    return std::make_unique<End>(wire, true, cut_);
  };
  return MakeGalvoDriver(profile, open, [this] { return now_; });
}

void HeadBench::Restart() {
  driver_ = NewDriver(profile_);
  events.clear();
}

void HeadBench::AdvanceHead(std::chrono::milliseconds time) {
  constexpr std::chrono::microseconds kPart{200};
  for (std::chrono::nanoseconds done{0}; done < time; done += kPart) {
    now_ += kPart;
    if (machine_) (void)machine_->Turn();
  }
}

void HeadBench::Step() {
  now_ += std::chrono::microseconds(200);
  machine_->Turn();
  driver_->Poll();
  const auto taken = driver_->TakeEvents();
  events.insert(events.end(), taken.begin(), taken.end());
  if (!permits || now_ < next_permit_) return;
  next_permit_ = now_ + std::chrono::milliseconds(20);
  (void)driver_->Permit(true);
}

void HeadBench::Run(std::uint32_t run, const mark::MarkSet& set, bool finish) {
  const auto begun = driver_->Begin(run, set.pens);
  ASSERT_TRUE(begun) << begun.error().message;
  for (std::uint32_t i = 0; i < set.marks.size(); ++i) {
    ASSERT_TRUE(Until([&] { return driver_->Room() > 0; })) << state().fault;
    const auto appended = driver_->Append({i, set.marks[i]});
    ASSERT_TRUE(appended) << appended.error().message;
  }
  if (finish) {
    ASSERT_TRUE(driver_->Finish());
  }
}

formats::MarkRecord HeadBench::Record() {
  EXPECT_TRUE(machine_->Flush());
  return formats::ReadMarkRecord(record_).value();
}

std::vector<MarkFate> HeadBench::FatesOf(std::uint32_t mark) const {
  std::vector<MarkFate> fates;
  for (const MarkEvent& event : events)
    if (event.mark == mark) fates.push_back(event.fate);
  return fates;
}

bool HeadBench::Has(std::uint32_t mark, MarkFate fate) const {
  return std::ranges::count(FatesOf(mark), fate) > 0;
}

}  // namespace intaglio::drivers
