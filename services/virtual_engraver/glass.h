#pragma once

// The glass: it records every crack, and what the head ran into, and refuses nothing.
// What it holds is on disk at the latest when Flush is called; a record file once begun
// is only appended to.

#include <filesystem>
#include <fstream>
#include <vector>

#include "engrave/core/result.h"
#include "engrave/formats/glass_record.h"

namespace intaglio::virtual_engraver {

/// Length of a crack along the beam: that of the laser's largest pulse is `full_mm`, and
/// the volume of the glass that is heated grows with the energy of the pulse. This is the
/// machine's own; engrave/optics/crack_model.h is what the services assume.
double CrackLengthMm(double full_mm, double energy_ratio);

class Glass {
 public:
  /// Begins the record file anew.
  static Result<Glass> Create(const std::filesystem::path& file,
                              const formats::GlassHeader& header);

  void Add(const formats::GlassCrack& crack);
  void Add(const formats::GlassCollision& collision);
  /// kIo when the disk refuses; what was not written is kept and tried again.
  Status Flush();
  std::uint64_t crack_count() const { return crack_count_; }

 private:
  Glass(std::filesystem::path path, std::ofstream out)
      : path_(std::move(path)), out_(std::move(out)) {}
  std::filesystem::path path_;
  std::ofstream out_;
  std::vector<std::byte> unwritten_;
  std::uint64_t crack_count_ = 0;
};

}  // namespace intaglio::virtual_engraver
