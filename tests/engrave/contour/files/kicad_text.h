#pragma once

// Boards as KiCad writes them, for the tests: the nets are known, since each pad is
// placed with its net.

#include <fmt/format.h>

#include <map>
#include <set>
#include <string>

namespace intaglio::contour::test {

class KicadText {
 public:
  KicadText() {
    text_ =
        "(kicad_pcb (version 20211014) (generator pcbnew)\n (general (thickness 1.6))\n"
        " (paper \"A4\")\n (layers (0 \"F.Cu\" signal) (31 \"B.Cu\" signal)\n"
        "  (36 \"B.SilkS\" user) (44 \"Edge.Cuts\" user))\n (setup (pad_to_mask 0))\n";
    Net("");
  }

  int Net(const std::string& name) {
    const auto [at, added] = nets_.try_emplace(name, static_cast<int>(nets_.size()));
    if (added) declared_ += fmt::format(" (net {} \"{}\")\n", at->second, name);
    return at->second;
  }
  void Outline(double x, double y, double width, double height) {
    const auto side = [&](double ax, double ay, double bx, double by) {
      body_ += fmt::format(
          " (gr_line (start {} {}) (end {} {}) (layer \"Edge.Cuts\") (width 0.1))\n", ax,
          ay, bx, by);
    };
    side(x, y, x + width, y);
    side(x, y + height, x + width, y + height);  // not in order, nor in one direction
    side(x + width, y, x + width, y + height);
    side(x, y + height, x, y);
  }
  void Footprint(const std::string& reference, double x, double y, double degrees = 0) {
    angle_ = degrees;
    body_ += fmt::format(
        " (footprint \"lib:{0}\" (layer \"F.Cu\") (at {1} {2} {3})\n"
        "  (fp_text reference \"{0}\" (at 0 -2) (layer \"F.SilkS\"))\n"
        "  (fp_line (start -1 -1) (end 1 -1) (layer \"F.SilkS\") (width 0.12))\n",
        reference, x, y, degrees);
  }
  /// At a place of the footprint; smd or thru_hole with a drill.
  void Pad(const std::string& number, const std::string& shape, double x, double y,
           double width, double height, const std::string& net, double drill = 0) {
    used_.insert(net);
    const std::string kind = drill > 0 ? "thru_hole" : "smd";
    body_ += fmt::format(
        "  (pad \"{}\" {} {} (at {} {} {}) (size {} {}) {} (roundrect_rratio 0.25) "
        "(net {} \"{}\"))\n",
        number, kind, shape, x, y, angle_, width, height,
        drill > 0 ? fmt::format("(drill {}) (layers *.Cu *.Mask)", drill)
                  : "(layers \"F.Cu\" \"F.Paste\" \"F.Mask\")",
        Net(net), net);
  }
  void EndFootprint() { body_ += " )\n"; }
  void Segment(double ax, double ay, double bx, double by, double width,
               const std::string& net, const std::string& layer = "F.Cu") {
    body_ += fmt::format(
        " (segment (start {} {}) (end {} {}) (width {}) (layer \"{}\") "
        "(net {}))\n",
        ax, ay, bx, by, width, layer, Net(net));
  }
  void Via(double x, double y, const std::string& net) {
    body_ += fmt::format(
        " (via (at {} {}) (size 0.8) (drill 0.4) (layers \"F.Cu\" "
        "\"B.Cu\") (net {}))\n",
        x, y, Net(net));
  }
  /// A filled zone: corners with cut-ins.
  void Zone(const std::string& net, const std::string& corners,
            const std::string& layer = "F.Cu") {
    body_ += fmt::format(
        " (zone (net {}) (net_name \"{}\") (layer \"{}\") (min_thickness "
        "0.25) (filled_areas_thickness no)\n  (fill yes (thermal_gap 0.5))"
        "\n  (filled_polygon (layer \"{}\") (pts {})))\n",
        Net(net), net, layer, layer, corners);
  }
  void Raw(const std::string& text) { body_ += text; }

  std::string Text() const { return text_ + declared_ + body_ + ")\n"; }
  /// Counts those with a pad.
  std::size_t NetCount() const { return used_.size(); }

 private:
  std::string text_;
  std::string declared_;
  std::string body_;
  std::map<std::string, int> nets_;
  std::set<std::string> used_;
  double angle_ = 0;
};

/// A ladder of eight resistors with leads, on one side.
inline KicadText LadderBoard() {
  KicadText board;
  board.Outline(90, 90, 120, 40);
  const auto net = [](int k) {
    return k == 0 ? std::string("IN") : k == 8 ? "OUT" : "N" + std::to_string(k);
  };
  for (int k = 0; k < 8; ++k) {
    const double x = 110 + 10 * k;
    board.Footprint("R" + std::to_string(k + 1), x, 100);
    board.Pad("1", "rect", 0, 0, 1.8, 1.8, net(k), 0.8);
    board.Pad("2", "circle", 0, 20, 1.8, 1.8, net(k + 1), 0.8);
    board.EndFootprint();
    if (k < 7) {
      board.Segment(x, 120, x + 5, 110, 0.5, net(k + 1));
      board.Segment(x + 5, 110, x + 10, 100, 0.5, net(k + 1));
    }
  }
  board.Footprint("J1", 100, 100, 90);
  board.Pad("1", "oval", 0, 0, 1.7, 3, "IN", 1);
  board.EndFootprint();
  board.Footprint("J2", 195, 120);
  board.Pad("1", "oval", 0, 0, 1.7, 3, "OUT", 1);
  board.EndFootprint();
  board.Segment(100, 100, 110, 100, 0.8, "IN");
  board.Segment(180, 120, 195, 120, 0.8, "OUT");
  return board;
}

/// A circuit of sixteen pins between two headers, the right one turned round, on two
/// sides; GND goes to the other header through vias.
inline KicadText FanBoard() {
  KicadText board;
  board.Outline(50, 50, 60, 40);
  const auto net = [](int k) {
    return k == 7 ? std::string("GND") : k == 15 ? "VCC" : "IO" + std::to_string(k);
  };
  board.Footprint("U1", 80, 70);
  for (int k = 0; k < 8; ++k) {
    const double y = (k - 3.5) * 1.27;
    board.Pad(std::to_string(k + 1), "roundrect", -2.7, y, 1.55, 0.6, net(k));
    board.Pad(std::to_string(16 - k), "roundrect", 2.7, y, 1.55, 0.6, net(8 + k));
  }
  board.EndFootprint();
  board.Footprint("J1", 60, 70);
  for (int k = 0; k < 8; ++k)
    board.Pad(std::to_string(k + 1), k == 0 ? "rect" : "circle", 0, (k - 3.5) * 2.54, 1.7,
              1.7, net(k), 1);
  board.EndFootprint();
  board.Footprint("J2", 100, 70, 180);
  for (int k = 0; k < 8; ++k)
    board.Pad(std::to_string(k + 1), "oval", 0, (k - 3.5) * 2.54, 2, 1.6, net(15 - k), 1);
  board.Pad("9", "circle", 0, 12, 1.7, 1.7, "GND", 1);
  board.EndFootprint();
  for (int k = 0; k < 8; ++k) {
    const double at = 70 + (k - 3.5) * 1.27;
    const double header = 70 + (k - 3.5) * 2.54;
    board.Segment(77.3, at, 74, at, 0.25, net(k));
    board.Segment(74, at, 60, header, 0.25, net(k));
    board.Segment(82.7, at, 86, at, 0.25, net(8 + k));
    board.Segment(86, at, 100, header, 0.25, net(8 + k));
  }
  // GND from the last pin of the left header below to the ninth of the right one.
  board.Segment(60, 78.89, 60, 84, 0.5, "GND");
  board.Via(60, 84, "GND");
  board.Segment(60, 84, 90, 84, 0.5, "GND", "B.Cu");
  board.Segment(90, 84, 96, 58, 0.5, "GND", "B.Cu");
  board.Via(96, 58, "GND");
  board.Segment(96, 58, 100, 58, 0.5, "GND");
  // A sensor turned by 45 degrees, with test points of its own.
  board.Footprint("R9", 80, 84, 45);
  board.Pad("1", "roundrect", -1, 0, 1, 1.3, "SENSE+");
  board.Pad("2", "roundrect", 1, 0, 1, 1.3, "SENSE-");
  board.EndFootprint();
  return board;
}

/// A plane with twelve pins, of which four are on it by thermal bridges; the signals run
/// on the other side.
inline KicadText PlaneBoard() {
  KicadText board;
  board.Outline(100, 100, 50, 40);
  // Clear squares of 3 mm about each pin, by cut-ins from the left; those of one row are
  // in each other's way, so each goes on from the one before.
  std::string corners = "(xy 101 101) (xy 149 101) (xy 149 139) (xy 101 139)";
  for (int row = 2; row >= 0; --row) {
    const double y = 110 + 10 * row;
    std::string way;
    std::string back;
    for (int column = 0; column < 4; ++column) {
      const double x = 110 + 10 * column;
      way += fmt::format(" (xy {0} {2}) (xy {0} {3}) (xy {1} {3}) (xy {1} {2})", x - 1.5,
                         x + 1.5, y, y - 1.5);
      back = fmt::format(" (xy {1} {2}) (xy {1} {3}) (xy {0} {3}) (xy {0} {2})", x - 1.5,
                         x + 1.5, y, y + 1.5) +
             back;
    }
    // The far side of the last square is one edge: both halves meet there.
    corners +=
        fmt::format(" (xy 101 {})", y) + way + back + fmt::format(" (xy 101 {})", y);
  }
  board.Zone("GND", corners);
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 4; ++column) {
      const double x = 110 + 10 * column;
      const double y = 110 + 10 * row;
      const bool on_plane = column == row || (row == 0 && column == 3);
      const std::string net = on_plane ? "GND" : "SIG" + std::to_string(row);
      board.Footprint(fmt::format("P{}{}", row, column), x, y);
      board.Pad("1", "circle", 0, 0, 1.8, 1.8, net, 1);
      board.EndFootprint();
      if (on_plane) {
        board.Segment(x - 2, y, x + 2, y, 0.5, "GND");
        board.Segment(x, y - 2, x, y + 2, 0.5, "GND");
      }
    }
  }
  const auto joined = [&](int row, int from, int to, double aside) {
    const double y = 110 + 10 * row;
    board.Segment(110 + 10 * from, y, 110 + 10 * from, y + aside, 0.4,
                  "SIG" + std::to_string(row), "B.Cu");
    board.Segment(110 + 10 * from, y + aside, 110 + 10 * to, y + aside, 0.4,
                  "SIG" + std::to_string(row), "B.Cu");
    board.Segment(110 + 10 * to, y + aside, 110 + 10 * to, y, 0.4,
                  "SIG" + std::to_string(row), "B.Cu");
  };
  joined(0, 1, 2, 4);
  joined(1, 0, 2, 4);
  joined(1, 2, 3, 3);
  joined(2, 0, 1, 4);
  joined(2, 1, 3, 4);
  return board;
}

}  // namespace intaglio::contour::test
