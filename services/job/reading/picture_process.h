#pragma once

// Pictures decoded by a process of their own, intaglio-picture-reader: whether they can
// be. Where the picture itself is needed, a program decodes it with image::ParseImage.

#include <chrono>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "engrave/core/result.h"
#include "engrave/image/image_file.h"

namespace intaglio::reading {

struct PictureProcess {
  std::filesystem::path program;  ///< intaglio-picture-reader
  /// Processor time. The largest photo of a block takes a tenth of that.
  std::chrono::seconds time{10};
};

/// The errors of image::ParseImage within these limits. Further ones: kNotFound (no such
/// program), kUnreadable (the process broke down), kTooLarge (it took too long), kIo.
/// `name`: of the file, for errors. Of any thread.
Status CheckPictureBy(const PictureProcess& process, std::string_view picture,
                      const image::ImageLimits& limits, std::string_view name);

/// How the process answers: its exit code, and the sentence on its standard output.
int ExitCodeOf(ErrorCode code);

}  // namespace intaglio::reading
