#pragma once

// A serial line as a pseudo-terminal: the host opens the symbolic link. The host's side
// is held open here, too, so that the death of a host is silence and not a hang-up.

#include <filesystem>
#include <memory>
#include <string>

#include "services/link/reliable_link.h"

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

 private:
  PtyLine() = default;
  struct Loss;
  std::filesystem::path link_path_;
  std::string name_;
  int master_ = -1;
  int held_slave_ = -1;
  std::shared_ptr<Loss> loss_;
};

}  // namespace intaglio::virtual_engraver
