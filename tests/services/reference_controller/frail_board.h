#pragma once

// Pins that can fail.

#include <memory>
#include <utility>

#include "services/reference_controller/pins.h"

namespace intaglio::reference_controller {

class FrailBoard final : public Pins {
 public:
  FrailBoard(Pins& pins, std::shared_ptr<bool> broken)
      : pins_(pins), broken_(std::move(broken)) {}
  bool Has(Output output) const override { return pins_.Has(output); }
  bool Has(Input input) const override { return pins_.Has(input); }
  Status Set(Output output, bool on) override {
    if (*broken_) return Broken();
    return pins_.Set(output, on);
  }
  Result<std::uint32_t> Levels() override {
    if (*broken_) return Broken();
    return pins_.Levels();
  }
  Result<std::optional<std::chrono::nanoseconds>> NextEdge(Input input) override {
    if (*broken_) return Broken();
    return pins_.NextEdge(input);
  }

 private:
  static tl::unexpected<Error> Broken() {
    return Fail(ErrorCode::kIo, "the board is broken");
  }
  Pins& pins_;
  std::shared_ptr<bool> broken_;
};

}  // namespace intaglio::reference_controller
