#include "engrave/drawing/dxf/dxf_xclip.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <utility>

#include "engrave/io/lower_case.h"

namespace intaglio::drawing {
namespace {

// Lengths and directions of a file that agree to so much are the same.
constexpr double kSame = 1e-9;
constexpr std::size_t kNumbersOfMatrix = 12;

/// Three rows of four; false: it flattens space.
bool AffineOf(const double* numbers, DxfAffine& affine) {
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column)
      affine.linear(row, column) = numbers[4 * row + column];
    affine.offset[row] = numbers[4 * row + 3];
  }
  return affine.linear.determinant() != 0;
}

DxfAffine InverseOf(const DxfAffine& affine) {
  const Mat3 inverse = affine.linear.inverse();
  return {inverse, -inverse * affine.offset};
}

PointList BoxAround(const PointList& points) {
  Box3 box;
  for (const Vec3& p : points) box.Extend(p);
  return {{box.min_mm.x(), box.min_mm.y(), 0},
          {box.max_mm.x(), box.min_mm.y(), 0},
          {box.max_mm.x(), box.max_mm.y(), 0},
          {box.min_mm.x(), box.max_mm.y(), 0}};
}

/// Two corners are those of a rectangle.
PointList OutlineOf(const PointList& corners) {
  return corners.size() == 2 ? BoxAround(corners) : corners;
}

double AreaOf(const PointList& outline) {
  double twice = 0;
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const Vec3 &p = outline[i], &q = outline[(i + 1) % outline.size()];
    twice += p.x() * q.y() - p.y() * q.x();
  }
  return std::abs(twice) / 2;
}

bool AreSame(const PointList& a, const PointList& b) {
  return std::ranges::equal(a, b, [](const Vec3& p, const Vec3& q) {
    return (p - q).head<2>().norm() <= kSame * (1 + p.norm());
  });
}

/// Takes a coordinate of a list of points, 10 20 30.
void TakeCorner(int code, double number, PointList& points) {
  if (code == 10) points.push_back(Vec3::Zero());
  if (!points.empty()) points.back()[code / 10 - 1] = number;
}

bool IsPoint(int code) { return code == 10 || code == 20 || code == 30; }

/// Reads the groups in braces that any object has: the handle of its dictionary.
class Reactors {
 public:
  /// True: the group belongs to them.
  bool Consume(const DxfGroup& group) {
    if (group.code == 102) {
      in_dictionary_ = group.value == "{ACAD_XDICTIONARY";
      in_braces_ = group.value.starts_with('{');
      return in_braces_ || group.value == "}";
    }
    if (in_dictionary_ && group.code == 360) dictionary = io::LowerCase(group.value);
    return in_braces_;
  }

  std::string dictionary;

 private:
  bool in_braces_ = false;
  bool in_dictionary_ = false;
};

}  // namespace

std::optional<ClipArea> DxfXclip::AreaOf(const DxfAffine& place_of_block,
                                         ClipWork& work) const {
  const DxfAffine to_place = place_of_block.Then(block_from_clip);
  // The clip reaches through its plane along the plane's normal.
  const Vec3 through = to_place.linear.col(2);
  if (through.head<2>().norm() > kSame * through.norm()) return std::nullopt;
  ClipShape shape{{}, true};
  for (const PointList& outline : outlines) {
    Polyline line;
    for (const Vec3& p : outline)
      line.points_mm.emplace_back(to_place.linear * p + to_place.offset);
    shape.outlines.push_back({{std::move(line)}, true});
  }
  return ClipArea::OfShapes({std::move(shape)}, work);
}

bool DxfXclips::Read(const DxfText& objects, DrawingBuilder& builder) {
  DxfEntities all(objects, builder);
  DxfEntity object;
  while (all.Next(object)) {
    bool is_read = true;
    if (object.type == "DICTIONARY") is_read = ReadDictionary(object, builder);
    if (object.type == "SPATIAL_FILTER") is_read = ReadFilter(object, builder);
    if (object.type == "XRECORD") is_read = ReadRecord(object, builder);
    if (!is_read) return false;
  }
  for (const auto& [handle, entries] : dictionaries_) {
    const auto filter = filters_.find(EntryOf(EntryOf(handle, "acad_filter"), "spatial"));
    if (filter == filters_.end()) continue;
    filter->second.is_found = true;
    if (filter->second.enabled) clips_.emplace(handle, ClipOf(filter->second));
  }
  for (const auto& [handle, filter] : filters_) {
    if (!filter.is_found && filter.enabled)
      builder.LeaveOut("XCLIP of a block, which is not named", Effect::kChanged,
                       filter.place);
  }
  return all.good();
}

const DxfXclip* DxfXclips::Find(std::string_view dictionary) const {
  const auto found = clips_.find(io::LowerCase(dictionary));
  return found == clips_.end() ? nullptr : &found->second;
}

/// Empty when there is no such dictionary, or no such entry.
std::string DxfXclips::EntryOf(const std::string& dictionary,
                               const std::string& name) const {
  const auto found = dictionaries_.find(dictionary);
  if (found == dictionaries_.end()) return {};
  const auto entry = found->second.find(name);
  return entry == found->second.end() ? std::string() : entry->second;
}

bool DxfXclips::ReadDictionary(const DxfEntity& object, DrawingBuilder& builder) {
  DxfGroups groups(object.groups, builder);
  DxfGroup group;
  Reactors reactors;
  std::string handle, name;
  Entries entries;
  while (groups.Next(group)) {
    if (reactors.Consume(group)) continue;
    if (group.code == 5) handle = io::LowerCase(group.value);
    if (group.code == 3) name = io::LowerCase(group.value);
    const bool wanted =
        name == "acad_filter" || name == "spatial" || name == "acad_xrec_roundtrip";
    if (wanted && (group.code == 350 || group.code == 360))
      entries.insert_or_assign(name, io::LowerCase(group.value));
  }
  if (entries.empty() || !groups.good()) return groups.good();
  dictionaries_.insert_or_assign(handle, std::move(entries));
  return builder.CountEntity(object.Place());
}

bool DxfXclips::ReadFilter(const DxfEntity& object, DrawingBuilder& builder) {
  if (!builder.CountEntity(object.Place())) return false;
  DxfGroups groups(object.groups, builder);
  DxfGroup group;
  Reactors reactors;
  std::string handle;
  Filter filter;
  filter.place = object.Place();
  while (groups.Next(group)) {
    if (reactors.Consume(group)) continue;
    if (group.code == 5) handle = io::LowerCase(group.value);
    const bool is_number = group.code >= 10 && group.code < 300 && group.code != 100;
    const std::optional<double> value = NumberOf(group.value);
    filter.is_wrong = filter.is_wrong || (is_number && !value);
    const double number = value.value_or(0);
    if (IsPoint(group.code)) TakeCorner(group.code, number, filter.corners);
    if (group.code == 11 || group.code == 21 || group.code == 31)
      filter.origin[group.code / 10 - 1] = number;
    if (group.code == 210 || group.code == 220 || group.code == 230)
      filter.normal[(group.code - 210) / 10] = number;
    if (group.code == 71) filter.enabled = number != 0;
    if (group.code == 72 || group.code == 73)
      filter.has_planes = filter.has_planes || number != 0;
    if (group.code == 40) filter.numbers.push_back(number);
  }
  filter.dictionary = reactors.dictionary;
  filters_.insert_or_assign(handle, std::move(filter));
  return groups.good();
}

bool DxfXclips::ReadRecord(const DxfEntity& object, DrawingBuilder& builder) {
  DxfGroups groups(object.groups, builder);
  DxfGroup group;
  Reactors reactors;
  std::string handle;
  Roundtrip record;
  PointList* points = nullptr;
  while (groups.Next(group)) {
    if (reactors.Consume(group)) continue;
    if (group.code == 5 && handle.empty()) handle = io::LowerCase(group.value);
    if (group.code == 102) {
      points = nullptr;
      if (group.value == "ACAD_INVERTEDCLIP_ROUNDTRIP") points = &record.hole;
      if (group.value == "ACAD_INVERTEDCLIP_ROUNDTRIP_COMPARE") points = &record.compared;
    } else if (points != nullptr && IsPoint(group.code)) {
      TakeCorner(group.code, NumberOf(group.value).value_or(0), *points);
    }
  }
  if (record.hole.empty() || !groups.good()) return groups.good();
  records_.insert_or_assign(handle, std::move(record));
  return builder.CountEntity(object.Place());
}

DxfXclip DxfXclips::ClipOf(const Filter& filter) const {
  DxfXclip clip;
  clip.place = filter.place;
  clip.has_planes = filter.has_planes;
  if (filter.is_wrong || filter.numbers.size() < 2 * kNumbersOfMatrix ||
      filter.corners.size() < 2) {
    clip.not_read = "without a boundary or its matrices";
    return clip;
  }
  DxfAffine block_from_world, clip_from_world;
  const double* numbers = filter.numbers.data() + filter.numbers.size();
  if (!AffineOf(numbers - 2 * kNumbersOfMatrix, block_from_world) ||
      !AffineOf(numbers - kNumbersOfMatrix, clip_from_world)) {
    clip.not_read = "with a matrix that flattens it";
    return clip;
  }
  clip.block_from_clip = block_from_world.Then(InverseOf(clip_from_world));
  const Vec3 origin = clip_from_world.linear * filter.origin + clip_from_world.offset;
  if ((filter.normal - Vec3::UnitZ()).norm() > kSame ||
      origin.head<2>().norm() > kSame * (1 + filter.origin.norm()))
    clip.not_read = "in a plane of its own";
  clip.outlines = {OutlineOf(filter.corners)};
  const auto record = records_.find(EntryOf(filter.dictionary, "acad_xrec_roundtrip"));
  if (record == records_.end()) return clip;
  // The frame without the hole, when the boundary is that with the slit.
  const PointList& compared = record->second.compared;
  const PointList frame = BoxAround(compared), hole = OutlineOf(record->second.hole);
  const double left = AreaOf(frame) - AreaOf(hole) - AreaOf(OutlineOf(filter.corners));
  if (!AreSame(compared, filter.corners) || std::abs(left) > 1e-3 * AreaOf(frame)) {
    clip.not_read = "inverted, with a boundary of another form";
  } else {
    clip.outlines = {frame, hole};
  }
  return clip;
}

}  // namespace intaglio::drawing
