#include "tests/integration/scan_picture.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <random>
#include <string>

namespace intaglio::testing {

void WriteScan(const std::filesystem::path& file, const std::vector<float>& covered) {
  const auto side = static_cast<int>(std::lround(std::sqrt(covered.size())));
  const auto row_bytes = static_cast<std::size_t>((3 * side + 3) / 4 * 4);
  std::mt19937 random(1);
  std::normal_distribution<double> noise(0, 2);
  std::string bytes(54 + row_bytes * static_cast<std::size_t>(side), '\0');
  const auto put = [&](std::size_t at, std::uint32_t value) {
    for (int k = 0; k < 4; ++k) bytes[at + k] = static_cast<char>(value >> 8 * k);
  };
  const auto sides = static_cast<std::uint32_t>(side);
  bytes[0] = 'B', bytes[1] = 'M';
  put(2, static_cast<std::uint32_t>(bytes.size())), put(10, 54), put(14, 40);
  put(18, sides), put(22, sides), put(26, 1 | 24 << 16);
  for (int j = 0; j < side; ++j) {
    for (int i = 0; i < side; ++i) {
      const auto at = static_cast<std::size_t>(j * side + i);
      const double r = std::hypot(i - side / 2, j - side / 2) / (side / 2);
      const double light =
          200 * (1 - 0.15 * r * r) * (1 - 0.5 * std::min(1.0F, covered[at])) +
          noise(random);
      for (std::size_t k = 0; k < 3; ++k) {
        bytes[54 + row_bytes * static_cast<std::size_t>(j) +
              3 * static_cast<std::size_t>(i) + k] =
            static_cast<char>(std::clamp(light, 0.0, 255.0));
      }
    }
  }
  std::ofstream(file, std::ios::binary) << bytes;
}

}  // namespace intaglio::testing
