#pragma once

// From one mark to lines of G-code for the grbl family.
//
//   laser    G0 X Y          dark        spindle    G0 Z safe
//            M4 S0                                  G0 X Y
//            G1/G2/G3 F S    lit, once a pass       G1 Z depth F plunge
//            M5 S0                                  G1/G2/G3 F, once a pass, deeper
//                                                   G0 Z safe
//
// A line, rapids among them, lasts kPiece_s at most, so that what a controller holds can
// be bounded in time. Pieces of one way are collinear or on one circle: the controller's
// junctions do not slow them down. An arc of a piece is at most a quarter of a circle,
// with its centre (I, J) from the place that was sent, so that roundings do not add up.
//
// Source: NIST RS274NGC (Kramer, Proctor, Messina 2000), ch. 3.5; of blocks a line,
// grbl 1.1 motion_control.c, mc_arc.
//
// Frame: G54, mm; z up, 0 on the work.

#include <cstdint>
#include <deque>
#include <optional>
#include <string>

#include "engrave/contour/edge.h"
#include "engrave/mark/mark.h"
#include "services/drivers/grbl/grbl_line.h"
#include "services/drivers/interface/mark_edges.h"

namespace intaglio::drivers {

struct CourseLine {
  std::string text;
  double seconds = 0;  ///< of its motion at the speed asked for
  int blocks = 0;      ///< that it fills in the controller's planner
};

struct CourseToolOptions {
  GrblTool tool = GrblTool::kLaser;
  double safe_height_mm = 5;
  bool lines_only = false;  ///< chords within kChord_mm in place of arcs
};

class GrblCourseProgram {
 public:
  static constexpr double kPiece_s = 0.05;
  static constexpr double kChord_mm = 0.001;

  explicit GrblCourseProgram(const CourseToolOptions& options) : options_(options) {}

  /// The controller's modal state is that after the set-up.
  void SetController(const GrblTraits& traits);
  /// Where the tool is at rest, when nothing is sent.
  void RestAt(const Vec3& place_mm);
  /// `mark` has been checked (CheckMark).
  void Begin(const mark::Mark& mark, const mark::Pen& pen);
  /// None: all of the mark has been given out.
  std::optional<CourseLine> Next();
  /// What was not given out is forgotten.
  void Drop();
  /// All places to which the lines that were given out since RestAt or Begin lead.
  const Box3& reach() const { return reach_; }

 private:
  enum class Kind { kRapid, kWork };
  struct Leg {
    std::string command;  ///< in place of a motion
    Kind kind = Kind::kRapid;
    contour::Edge edge;  ///< in the plane
    double from_z_mm = 0, to_z_mm = 0;
    double speed_mm_s = 0;
    std::uint64_t piece = 0, piece_count = 1;
    double length_mm() const;
  };

  void AddRapid(const Vec3& to_mm);
  void AddWork(const contour::Edge& edge);
  void AddPlunge(double z_mm);
  void AddCommand(std::string text);
  void AddPass();
  void AddEnd();
  void Divide(Leg& leg) const;
  std::optional<CourseLine> LineOf(const Leg& leg);
  CourseLine Motion(const Leg& leg, const Vec3& to_mm);
  std::string CoordinatesTo(const Vec3& to_mm) const;
  int BlocksOfArc(const contour::Edge& arc) const;
  bool IsStep(const Vec3& from_mm, const Vec3& to_mm) const;

  CourseToolOptions options_;
  GrblTraits traits_;
  std::vector<contour::Edge> edges_;  ///< of the mark, once around
  bool closed_ = false;
  mark::Pen pen_;
  std::uint32_t pass_ = 0;
  bool ended_ = true;
  std::deque<Leg> legs_;
  Vec3 planned_mm_ = Vec3::Zero();  ///< end of legs_
  Vec3 at_mm_ = Vec3::Zero();       ///< of what was given out, as it was printed
  Box3 reach_;
  std::string feed_text_, power_text_ = "S0";
};

}  // namespace intaglio::drivers
