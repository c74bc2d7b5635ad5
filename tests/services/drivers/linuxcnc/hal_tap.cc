#include "tests/services/drivers/linuxcnc/hal_tap.h"

#include <algorithm>
#include <array>

namespace intaglio::linuxcnc {

/// The driver's end.
class HalTap::Handle final : public drivers::HalLine {
 public:
  explicit Handle(HalTap& tap) : tap_(tap) {}
  // Other programs for the next session: what is torn is gone with the old ones.
  ~Handle() override {
    if (tap_.line_) tap_.Plug();
  }
  Status WriteRows(std::string_view lines) override {
    return tap_.line_ ? tap_.line_->WriteRows(tap_.Pass(lines)) : Gone();
  }
  Status WriteCommands(std::string_view lines) override {
    return tap_.line_ ? tap_.line_->WriteCommands(tap_.Pass(lines)) : Gone();
  }
  Result<std::size_t> ReadSamples(std::span<char> buffer) override {
    if (!tap_.line_) return Gone();
    const std::size_t count = std::min(buffer.size(), tap_.to_driver_.size());
    std::copy_n(tap_.to_driver_.begin(), count, buffer.begin());
    tap_.to_driver_.erase(0, count);
    return count;
  }
  int fd() const override { return -1; }

 private:
  static tl::unexpected<Error> Gone() {
    return Fail(ErrorCode::kLinkLost, "HAL has ended");
  }
  HalTap& tap_;
};

drivers::HalOpener HalTap::Opener() {
  return [this]() -> Result<std::unique_ptr<drivers::HalLine>> {
    if (!line_) return Fail(ErrorCode::kIo, "HAL does not run");
    to_driver_.clear();
    return std::make_unique<Handle>(*this);
  };
}

void HalTap::Plug() {
  line_.reset();
  partial_.clear();
  to_driver_.clear();
  if (auto line = drivers::OpenHalLine()) line_ = std::move(*line);
}

void HalTap::Cut(bool cut) {
  bytes_left_ = cut ? std::optional<std::uint64_t>(0) : std::nullopt;
}

std::string_view HalTap::Pass(std::string_view text) {
  if (!bytes_left_) return text;
  const std::size_t count = std::min<std::uint64_t>(*bytes_left_, text.size());
  *bytes_left_ -= count;
  return text.substr(0, count);
}

void HalTap::Pump() {
  std::array<char, 65536> buffer;
  while (line_) {
    const auto count = line_->ReadSamples(buffer);
    if (!count) return line_.reset();
    if (*count == 0) return;
    const std::string_view text(buffer.data(), *count);
    if (!cut()) to_driver_ += text;
    partial_ += text;
    for (auto end = partial_.find('\n'); end != std::string::npos;
         end = partial_.find('\n')) {
      const auto sample = drivers::ParseSample(std::string_view(partial_).substr(0, end));
      partial_.erase(0, end + 1);
      if (!sample) continue;
      still_samples_ = sample->actual_mm == newest_.actual_mm ? still_samples_ + 1 : 0;
      if (still_samples_ == 0 || sample->Has(drivers::kHalLaser)) ++work_count_;
      newest_ = *sample;
      if (records_) recorded_.push_back(*sample);
    }
  }
}

}  // namespace intaglio::linuxcnc
