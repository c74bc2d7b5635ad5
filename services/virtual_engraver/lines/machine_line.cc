#include "services/virtual_engraver/lines/machine_line.h"

#include <functional>
#include <random>
#include <string_view>
#include <utility>

#include "services/virtual_engraver/lines/pty_line.h"
#include "services/virtual_engraver/lines/tcp_line.h"

namespace intaglio::virtual_engraver {

struct MachineLine::Loss {
  double ratio = 0;
  std::mt19937 random = {};

  bool Happens() {
    return ratio > 0 && std::uniform_real_distribution<double>(0, 1)(random) < ratio;
  }
};

namespace {

/// Loses those of the bytes that come in for which `loses` returns true.
class LossyStream final : public link::ByteStream {
 public:
  LossyStream(std::unique_ptr<link::ByteStream> inner, std::function<bool()> loses)
      : inner_(std::move(inner)), loses_(std::move(loses)) {}

  Result<std::size_t> Read(std::span<std::byte> buffer) override {
    auto got = inner_->Read(buffer);
    if (!got) return got;
    std::size_t kept = 0;
    for (std::size_t i = 0; i < *got; ++i) {
      if (!loses_()) buffer[kept++] = buffer[i];
    }
    return kept;
  }
  Result<std::size_t> Write(std::span<const std::byte> bytes) override {
    return inner_->Write(bytes);
  }
  int fd() const override { return inner_->fd(); }

 private:
  std::unique_ptr<link::ByteStream> inner_;
  std::function<bool()> loses_;
};

template <typename Line>
Result<std::unique_ptr<MachineLine>> OnHeap(Result<Line> line) {
  if (!line) return tl::unexpected(line.error());
  return std::make_unique<Line>(std::move(*line));
}

}  // namespace

MachineLine::MachineLine() : loss_(std::make_shared<Loss>()) {}

std::unique_ptr<link::ByteStream> MachineLine::MachineEnd() {
  return std::make_unique<LossyStream>(HostBytes(),
                                       [loss = loss_] { return loss->Happens(); });
}

void MachineLine::DropBytes(double ratio, unsigned seed) {
  loss_->ratio = ratio;
  loss_->random.seed(seed);
}

Result<std::unique_ptr<MachineLine>> OpenMachineLine(const std::string& device,
                                                     const std::string& name) {
  constexpr std::string_view kTcp = "tcp:";
  if (!device.starts_with(kTcp)) return OnHeap(PtyLine::Open(device, name));
  return OnHeap(TcpLine::Open(device.substr(kTcp.size()), name));
}

}  // namespace intaglio::virtual_engraver
