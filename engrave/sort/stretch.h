#pragma once

// A stretch of an order under annealing: some thousand consecutive points, of which the
// first two and the last two stay where they are, so that neighbouring stretches can be
// annealed at the same time.
//
// A change takes a piece of the order out and puts it elsewhere (Or-opt), or turns a
// piece round (2-opt), so that two near points become neighbours. It is accepted when it
// costs less than before plus a random amount that grows with the temperature
// (Metropolis' rule) and keeps every point before those that it must precede. Cost:
// tick_cost.h; ticks of the steps around a change are chosen again with it.

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "engrave/core/geometry.h"
#include "engrave/core/quick_random.h"
#include "engrave/sort/beam/beam_cone.h"
#include "engrave/sort/beam/precedence.h"
#include "engrave/sort/near/near_points.h"
#include "engrave/sort/near/tick_cost.h"
#include "engrave/sort/near/way_speeds.h"

namespace intaglio::sort {

/// The heights of a slow third axis while it passes a stretch: a point may come to each
/// place at which the axis is near enough to the height of the point.
struct HeightTube {
  std::span<const double> points_mm = {};  ///< Of each point its height.
  std::span<const double> axis_mm = {};    ///< Of each place the height of the axis.
  double tolerance_mm = 0;
};

class Stretch {
 public:
  /// points_mm: in the present order, which keeps to `cone`; frame glass, mm. `cost`
  /// outlives this.
  Stretch(std::span<const Vec3> points_mm, const BeamCone& cone, const TickCost& cost);
  /// The same with a tube, whose lists are as long as points_mm and outlive this. A point
  /// that is outside of the tube at the beginning may stay where it is.
  Stretch(std::span<const Vec3> points_mm, const BeamCone& cone, const TickCost& cost,
          const HeightTube& tube);

  /// Cools from `hot` to `cold`, both in ticks, > 0.
  void Anneal(std::uint64_t tries, double hot, double cold, std::uint64_t seed);

  /// Indices into points_mm.
  std::span<const std::uint32_t> order() const { return at_; }

 private:
  friend class StretchSearch;

  Stretch(const std::vector<Scaled>& points, std::span<const Vec3> points_mm,
          const BeamCone& cone, const TickCost& cost, const HeightTube& tube);

  /// The places [begin, end) are two pieces that meet at `middle`; they change places,
  /// and one may be turned round. With middle == end it is one piece, turned round.
  struct Change {
    std::size_t begin, middle, end;
    bool turn_left, turn_right;
  };
  /// Places at each end whose points stay.
  static constexpr std::size_t kFixed = 2;
  /// Three joints, each with a step on both sides.
  static constexpr std::size_t kMaxWindowSteps = 9;
  /// Neighbouring steps whose ticks are chosen again.
  struct Window {
    std::size_t first, last;  ///< of the steps' places; step i leads to place i
    float ticks[kMaxWindowSteps];
  };
  /// What is known of a place: its point, and the step that leads to it. Together, as it
  /// is used: most changes are refused by some of it alone.
  struct Place {
    Scaled point;
    float height_mm;  ///< of its point in the tube, from the first one's
    float ticks;
    float min_ticks;
    float bend_cost;  ///< between the step before and this one
  };

  /// A way through the windows while it is compared with others.
  struct Way {
    SpeedBox speeds;  ///< possible at its end
    TimedMove last;
    float cost;
    float ticks[kMaxWindowSteps];
    std::size_t count;  ///< of the ticks
  };
  /// The cheapest so far, in the order of their cost.
  struct Ways {
    static constexpr std::size_t kMaxWays = 4;

    bool IsFullAt(float cost) const;
    void Keep(const Way& way);

    Way all[kMaxWays];
    std::size_t count = 0;
  };

  std::uint32_t Below(std::uint32_t end) {
    return static_cast<std::uint32_t>(((random_() >> 32) * end) >> 32);
  }
  void ChooseTicks();
  void ChooseTicksOfWay();
  void ChooseTicksOfNeighbours();
  void FindSlow();
  std::size_t PlaceToImprove();
  bool Propose(const NearPoints& all_near, Change& change);
  std::size_t PieceLength(std::size_t place, bool forwards);
  std::size_t SmoothLength(std::size_t place, bool forwards, std::size_t longest) const;
  std::size_t OldPlace(const Change& change, std::size_t place) const;
  TimedMove MoveTo(std::size_t place) const;
  void SetStepTo(std::size_t place);
  void SetBends(std::size_t first, std::size_t last);
  TimedMove MoveAfter(const Change& change, std::size_t place) const;
  std::size_t WindowsAround(const std::size_t (&steps)[3], Window (&windows)[3]) const;
  std::optional<float> BearableGain(const Change& change, double bearable);
  float MaxGain(const Change& change, double bearable);
  float Gain(const Change& change, double bearable);
  void PassStep(const Scaled& step, float limit, Ways& ways) const;
  void PassPiece(const Change& change, std::size_t first, std::size_t last, float limit,
                 Ways& ways) const;
  const Way* CheapestInto(const TimedMove& after, std::size_t place, float limit,
                          Ways& ways) const;
  float NewMinTicks(const Change& change) const;
  bool IsAllowed(const Change& change) const;
  bool StaysInTubeAt(const Change& change, std::size_t place) const;
  bool EndsStayInTube(const Change& change) const;
  bool StaysInTube(const Change& change) const;
  bool PieceStaysInTube(std::size_t begin, std::size_t end, bool turned,
                        std::size_t to) const;
  bool CanTurn(std::size_t begin, std::size_t end) const;
  void Apply(const Change& change);
  void ApplyToSpeeds(const Change& change);

  const TickCost& cost_;
  WaySpeeds speeds_;  ///< where the whole way has to fit
  std::vector<Place> places_;
  std::vector<std::uint32_t> at_;     ///< of each place its point
  std::vector<std::uint32_t> place_;  ///< of each point its place
  bool has_tube_;
  float tolerance_mm_;
  std::vector<float> axis_mm_;  ///< of each place, from the first point's height
  Precedence precedence_;
  float typical_step_;
  NearPoints near_;
  QuickRandom random_;
  /// Places that a step of more than one tick leads to or leaves, as they were at most
  /// kTriesASearch tries ago.
  std::vector<std::uint32_t> slow_;
  Window new_windows_[3];
  std::size_t new_window_count_ = 0;
  float old_cost_ = 0;  ///< of the windows that a change leaves
  std::vector<std::uint32_t> moved_;
  std::vector<Place> moved_places_;
};

}  // namespace intaglio::sort
