#pragma once

// What is printed on the web of a virtual scan head, and which of it the photo eye sees:
// print marks in rows that stretch, some that are missing, and dirt that looks like one.
// All places are how far the web has moved since power-up when the edge passes the eye,
// mm.

#include <cstdint>
#include <optional>
#include <vector>

namespace intaglio::virtual_engraver {

struct PrintOptions {
  double pitch_mm = 0;       ///< of the print before it stretched; 0: nothing is printed
  double stretch_ratio = 0;  ///< longer by this, above -0.5
  double ripple_ratio = 0;   ///< the stretch changes along the web by this, 0..0.5
  double ripple_mm = 500;    ///< in this length, as a sine
  std::vector<std::uint32_t> missing = {};  ///< numbers of print marks, from 0
  std::vector<double> false_mm = {};        ///< where something passes that is none
};

class PrintedWeb {
 public:
  explicit PrintedWeb(const PrintOptions& options);

  /// Where the edge of this print mark passes, whether it is printed or missing.
  double PlaceOf(std::uint32_t number) const;

  struct Passed {
    double place_mm = 0;
    bool printed = false;  ///< false: dirt
  };
  /// The next that passes while the web moves to this place; none: nothing does. A web
  /// that moves back is not seen.
  std::optional<Passed> Next(double web_mm);

 private:
  std::optional<Passed> FindNext();

  PrintOptions options_;
  std::uint32_t next_ = 0;  // print mark
  std::size_t next_false_ = 0;
  std::optional<Passed> found_;  // the next one
};

}  // namespace intaglio::virtual_engraver
