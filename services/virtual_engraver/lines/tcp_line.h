#pragma once

// A line over TCP: the machine listens, and has one host at a time. A second one is
// turned away (its connection is reset) as long as the first is connected, so that no
// other host takes a machine in mid-job. A host whose computer lost its power, or its
// cable, frees the line after link::kTcpSilentMs.
//
//   waiting --a host connects--> taken --it closes, or the kernel gives it up--> gone
//      ^                                                                          |
//      +------------------------------- HostHasGone() ----------------------------+

#include "services/virtual_engraver/lines/machine_line.h"

namespace intaglio::virtual_engraver {

class TcpLine final : public MachineLine {
 public:
  /// `address`: "HOST:PORT" (link::ParseTcpAddress); port 0 chooses a free one.
  static Result<TcpLine> Open(const std::string& address, const std::string& name);
  TcpLine(TcpLine&&) noexcept;
  TcpLine& operator=(TcpLine&&) noexcept;
  ~TcpLine() override;

  bool HostHasGone() override;
  std::string device() const override;
  std::array<int, 2> descriptors() const override;

 private:
  struct Socket;
  class Stream;
  explicit TcpLine(std::shared_ptr<Socket> socket);
  std::unique_ptr<link::ByteStream> HostBytes() override;

  std::shared_ptr<Socket> socket_;
};

}  // namespace intaglio::virtual_engraver
