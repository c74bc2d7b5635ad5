#include "tests/integration/campaign/true_account.h"

#include <algorithm>
#include <cmath>

namespace intaglio::campaign {
namespace {

using formats::PointOutcome;

// Places of an item that are looked at, away from the one where it closes.
constexpr int kPlaces = 16;
constexpr double kFirstPlace = 0.4;
// The places of a piece of work that are compared with the items are so far apart.
constexpr double kSpacing_mm = 0.25;

double DistanceToWay(const Vec3& place_mm, const Vec3& from_mm, const Vec3& to_mm) {
  const Vec3 way = to_mm - from_mm;
  const double along =
      way.squaredNorm() > 0
          ? std::clamp((place_mm - from_mm).dot(way) / way.squaredNorm(), 0.0, 1.0)
          : 0;
  return (from_mm + along * way - place_mm).norm();
}

double DistanceToItem(const Vec3& place_mm, const Item& item) {
  double nearest_mm = (place_mm - item.front()).norm();
  for (std::size_t i = 1; i < item.size(); ++i)
    nearest_mm = std::min(nearest_mm, DistanceToWay(place_mm, item[i - 1], item[i]));
  return nearest_mm;
}

PointList PlacesOf(const Item& item) {
  if (item.size() == 1) return item;
  double length_mm = 0;
  for (std::size_t i = 1; i < item.size(); ++i)
    length_mm += (item[i] - item[i - 1]).norm();
  PointList places;
  double passed_mm = 0;
  for (std::size_t i = 1; i < item.size(); ++i) {
    const Vec3 way = item[i] - item[i - 1];
    for (;;) {
      const double at_mm =
          length_mm * (static_cast<double>(places.size()) + kFirstPlace) / kPlaces;
      if (places.size() == kPlaces || at_mm > passed_mm + way.norm()) break;
      places.push_back(item[i - 1] + way.normalized() * (at_mm - passed_mm));
    }
    passed_mm += way.norm();
  }
  return places;
}

/// Pieces near the place that follow each other are one visit.
std::size_t VisitsAt(const Vec3& place_mm, const std::vector<WorkPiece>& work,
                     double near_mm) {
  std::size_t visits = 0;
  bool by = false;
  for (const WorkPiece& piece : work) {
    const bool is_by = DistanceToWay(place_mm, piece.from_mm, piece.to_mm) < near_mm;
    visits += is_by && (!by || piece.is_whole);
    by = is_by;
  }
  return visits;
}

/// What the journal says last of each item; an intent without an outcome is uncertain.
std::vector<PointOutcome> LastOutcomes(const formats::Journal& journal,
                                       std::size_t count) {
  std::vector<PointOutcome> last(count, PointOutcome::kNone);
  for (const formats::JournalRecord& record : journal.records) {
    if (!formats::IsOfPoint(record.kind)) continue;
    if (record.kind == formats::JournalKind::kReopened) continue;
    last.at(record.point) = record.kind == formats::JournalKind::kIntent
                                ? PointOutcome::kUncertain
                                : record.outcome;
  }
  return last;
}

/// Which items the pieces touch; a piece beside all of them is stray.
std::vector<bool> Touched(const std::vector<Item>& items,
                          const std::vector<WorkPiece>& work, double near_mm,
                          Account& account) {
  std::vector<bool> touched(items.size(), false);
  for (const WorkPiece& piece : work) {
    const Vec3 way = piece.to_mm - piece.from_mm;
    const int count = std::max(1, static_cast<int>(std::ceil(way.norm() / kSpacing_mm)));
    double farthest_mm = 0;
    for (int i = 0; i <= count; ++i) {
      const Vec3 place_mm = piece.from_mm + way * i / count;
      double nearest_mm = 1e9;
      std::size_t nearest = 0;
      for (std::size_t k = 0; k < items.size(); ++k) {
        const double distance_mm = DistanceToItem(place_mm, items[k]);
        if (distance_mm < nearest_mm) nearest_mm = distance_mm, nearest = k;
      }
      if (nearest_mm <= near_mm) touched[nearest] = true;
      farthest_mm = std::max(farthest_mm, nearest_mm);
    }
    account.stray += farthest_mm > near_mm;
    account.stray_mm = std::max(account.stray_mm, farthest_mm);
  }
  return touched;
}

}  // namespace

Account AccountOf(const std::vector<Item>& items, const std::vector<WorkPiece>& work,
                  const formats::Journal& journal, double near_mm) {
  Account account;
  account.items = items.size();
  const auto last = LastOutcomes(journal, items.size());
  const auto touched = Touched(items, work, near_mm, account);
  for (std::size_t k = 0; k < items.size(); ++k) {
    std::size_t visited = 0, again = 0;
    const PointList places = PlacesOf(items[k]);
    for (const Vec3& place_mm : places) {
      const std::size_t visits = VisitsAt(place_mm, work, near_mm);
      visited += visits > 0;
      again += visits > 1;
    }
    const bool whole = visited == places.size();
    const bool uncertain = last[k] == PointOutcome::kUncertain;
    const bool fired = formats::IsFired(last[k]);
    account.made += whole;
    account.doubled += places.size() == 1 ? again > 0 : again > 1;
    account.uncertain += uncertain;
    account.unknown += !uncertain && (fired ? !whole : touched[k]);
  }
  return account;
}

double AmountOf(const std::vector<WorkPiece>& work) {
  double amount = 0;
  for (const WorkPiece& piece : work)
    amount += piece.is_whole ? 1 : (piece.to_mm - piece.from_mm).norm();
  return amount;
}

}  // namespace intaglio::campaign
