#pragma once

// A serial line as a pseudo-terminal: the host opens the symbolic link.

#include <filesystem>

#include "services/virtual_engraver/lines/machine_line.h"

namespace intaglio::virtual_engraver {

class PtyLine final : public MachineLine {
 public:
  /// kIo when there is no pseudo-terminal or the link cannot be made. The link is removed
  /// with the line.
  static Result<PtyLine> Open(const std::filesystem::path& link_path,
                              const std::string& name);
  PtyLine(PtyLine&&) noexcept;
  PtyLine& operator=(PtyLine&&) noexcept;
  ~PtyLine() override;

  bool HostHasGone() override;
  std::string device() const override;
  std::array<int, 2> descriptors() const override;
  /// A host has its end open.
  bool host_there() const;

 private:
  struct Terminal;
  explicit PtyLine(std::unique_ptr<Terminal> terminal);
  std::unique_ptr<link::ByteStream> HostBytes() override;

  std::unique_ptr<Terminal> terminal_;
  bool host_was_there_ = false;
};

}  // namespace intaglio::virtual_engraver
