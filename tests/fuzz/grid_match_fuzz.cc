// Any places as the marks of a calibration grid: refused with a message, or matched to
// nodes, each once. (A fit takes a second with sanitizers.)

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <set>
#include <vector>

#include "engrave/core/check.h"
#include "engrave/galvo/calibration_grid.h"
#include "engrave/galvo/grid_match.h"

// Each place has the node of the grid that it is near, and how far from it, so that whole
// grids are not rare.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace intaglio;
  constexpr double kPitchMm = 10;
  std::vector<Vec2> places_mm = galvo::CalibrationGrid(5, kPitchMm);
  places_mm.push_back(galvo::DirectionDisc(kPitchMm));
  const std::size_t nodes = places_mm.size();
  for (std::size_t at = 0; at + 5 <= size && at < 500; at += 5) {
    std::int16_t by[2];
    std::memcpy(by, bytes + at + 1, sizeof(by));
    const Vec2 by_mm = Vec2(by[0], by[1]) / 512;
    if (bytes[at] < 200) {
      places_mm[bytes[at] % nodes] += by_mm / 8;
    } else {
      places_mm.push_back(by_mm);
    }
  }
  const auto match = galvo::MatchGrid(places_mm, 5, kPitchMm);
  if (!match) {
    Require(!match.error().message.empty(), "an error without a sentence");
    return 0;
  }
  std::set<std::pair<long, long>> commands;
  for (const galvo::GridMark& mark : match->marks) {
    Require(mark.measured_mm.allFinite(), "no place");
    commands.emplace(std::lround(mark.command_mm.x()), std::lround(mark.command_mm.y()));
  }
  Require(commands.size() == match->marks.size(), "two marks of one node");
  Require(match->marks.size() + match->left_out_count + (match->quarter_turns ? 1 : 0) ==
              places_mm.size(),
          "marks are lost");
  return 0;
}
