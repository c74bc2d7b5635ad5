#pragma once

// A picture of a scanner or a microscope, for tests: dark places on a ground that falls
// off to the corners, with noise.

#include <filesystem>
#include <vector>

namespace intaglio::testing {

/// `covered`: how much of each pixel is dark, from 0, rows from the bottom; a square. 24
/// bits, .bmp.
void WriteScan(const std::filesystem::path& file, const std::vector<float>& covered);

}  // namespace intaglio::testing
