#pragma once

// A serial line as a pseudo-terminal: the host opens the symbolic link. When it closes
// its port, or dies, the machine is told at once, as by a line's DTR; a host that hangs,
// and a cable that breaks, are silence.

#include <filesystem>
#include <memory>
#include <string>

#include "services/platform/link/reliable_link.h"

namespace intaglio::virtual_engraver {

class PtyLine {
 public:
  /// kIo when there is no pseudo-terminal or the link cannot be made.
  static Result<PtyLine> Open(const std::filesystem::path& link_path,
                              const std::string& name);
  PtyLine(PtyLine&& other) noexcept;
  PtyLine& operator=(PtyLine&& other) noexcept;
  ~PtyLine();  // removes the symbolic link

  /// The machine's end. Bytes that the host sends, and a share of them lost on purpose.
  std::unique_ptr<link::ByteStream> MachineEnd();
  /// Of every byte that comes in, this share is lost, 0..1; drawn from `seed`.
  void DropBytes(double ratio, unsigned seed);
  int fd() const { return master_; }
  /// A host has its end open.
  bool host_there() const;
  /// True once each time when the host has gone.
  bool HostHasGone();

 private:
  PtyLine() = default;
  struct Loss;
  std::filesystem::path link_path_;
  std::string name_;
  int master_ = -1;
  bool host_was_there_ = false;
  std::shared_ptr<Loss> loss_;
};

}  // namespace intaglio::virtual_engraver
