// The union of boards of 100 to 10 000 elements, beside CGAL's exact polygon set of lines
// and arcs where that is installed: processor time of one thread, and whether the areas
// agree. Prints a table in Markdown; `contour_bench N` with at most N elements.

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <ctime>

#include "engrave/contour/union.h"
#include "tests/bench/contour_peers.h"
#include "tests/engrave/contour/boards.h"

namespace intaglio::bench {

double ProcessorSeconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

namespace {

constexpr double kToolRadius_mm = 0.1;

/// The fastest of five, with the proof.
Result<contour::Union> Measure(const std::vector<contour::Element>& board,
                               double& seconds) {
  Result<contour::Union> united;
  seconds = 1e300;
  for (int k = 0; k < 5; ++k) {
    const double begin = ProcessorSeconds();
    united = contour::Unite(board, {kToolRadius_mm});
    seconds = std::min(seconds, ProcessorSeconds() - begin);
  }
  return united;
}

int Run(int max_count) {
  fmt::print(
      "| elements | tracks | ms | contours | CGAL, ms | times | areas differ, mm2 |\n"
      "|---|---|---|---|---|---|---|\n");
  for (const int count : {100, 1000, 10'000, 100'000}) {
    if (count > max_count) break;
    for (const bool free_angles : {false, true}) {
      const auto board = contour::test::MakeBoard({count, 7, free_angles});
      double seconds = 0;
      const auto united = Measure(board, seconds);
      const char* tracks = free_angles ? "at any angle" : "on the raster";
      if (!united) {
        fmt::print("| {} | {} | {} |\n", count, tracks, united.error().message);
        return 1;
      }
      fmt::print("| {} | {} | {:.1f} | {} |", count, tracks, 1e3 * seconds,
                 united->contours.size());
      const auto rounded = contour::Rounded(board);
      const auto peer =
          count <= 10'000 ? UniteByCgal(*rounded, kToolRadius_mm) : std::nullopt;
      if (peer)
        fmt::print(" {:.0f} | {:.0f} | {:.1g} |\n", 1e3 * peer->seconds,
                   peer->seconds / seconds, std::abs(peer->area_mm2 - united->area_mm2));
      else
        fmt::print(" | | |\n");
    }
  }
  return 0;
}

}  // namespace
}  // namespace intaglio::bench

int main(int argc, char** argv) {
  return intaglio::bench::Run(argc > 1 ? std::atoi(argv[1]) : 10'000);
}
