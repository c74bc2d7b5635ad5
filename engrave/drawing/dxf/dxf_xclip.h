#pragma once

// XCLIP: what is seen of an inserted block lies within a boundary.
//
// The extension dictionary of the INSERT has a dictionary ACAD_FILTER, and that a
// SPATIAL_FILTER under the name SPATIAL (DXF reference, SPATIAL_FILTER): corners in the
// plane of the clip (10; two are opposite corners of a rectangle), 71 = 0 when the clip
// is switched off, and two matrices of three rows of four (the last 24 numbers of code
// 40): the inverse of the transform that the block had when it was clipped, M, and that
// from the world into the plane of the clip, N. A corner c is at inverse(N) c in the
// world then, at M inverse(N) c in the block, and from there it moves with the block.
//
// An inverted clip is written as a boundary around the frame of the block and, through a
// slit, around the hole; an XRECORD ACAD_XREC_ROUNDTRIP of the filter has the hole
// itself.

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "engrave/drawing/clip.h"
#include "engrave/drawing/dxf/dxf_groups.h"
#include "engrave/drawing/dxf/dxf_insert.h"

namespace intaglio::drawing {

/// The boundary of a clip in the block's own coordinates, before its base point is moved.
struct DxfXclip {
  std::vector<PointList> outlines;  ///< inside by the odd number
  DxfAffine block_from_clip;
  bool has_planes = false;  ///< in front and behind, which are not obeyed
  std::string not_read;     ///< why there are no outlines: "in another plane"
  std::string place;        ///< "line 12, SPATIAL_FILTER"

  /// The area in the frame to which `place_of_block` leads. Nothing: the clip does not
  /// run along z there, or cannot be made.
  std::optional<ClipArea> AreaOf(const DxfAffine& place_of_block, ClipWork& work) const;
};

/// The clips of a file's section OBJECTS.
class DxfXclips {
 public:
  /// False: the builder has the error.
  bool Read(const DxfText& objects, DrawingBuilder& builder);

  /// The clip of an INSERT by the handle of its extension dictionary; null: it has none,
  /// or it is switched off.
  const DxfXclip* Find(std::string_view dictionary) const;

 private:
  struct Filter {
    std::string place;
    std::string dictionary;
    PointList corners;
    std::vector<double> numbers;  ///< of code 40
    Vec3 normal = Vec3::UnitZ();
    Vec3 origin = Vec3::Zero();
    bool enabled = true;
    bool is_wrong = false;  ///< a number of it
    bool is_found = false;  ///< through an extension dictionary
    bool has_planes = false;
  };
  struct Roundtrip {
    PointList hole;
    PointList compared;  ///< the boundary of the filter when the hole was written
  };
  using Entries = std::unordered_map<std::string, std::string>;

  bool ReadDictionary(const DxfEntity& object, DrawingBuilder& builder);
  bool ReadFilter(const DxfEntity& object, DrawingBuilder& builder);
  bool ReadRecord(const DxfEntity& object, DrawingBuilder& builder);
  std::string EntryOf(const std::string& dictionary, const std::string& name) const;
  DxfXclip ClipOf(const Filter& filter) const;

  std::unordered_map<std::string, Entries> dictionaries_;  ///< by handle
  std::map<std::string, Filter> filters_;
  std::unordered_map<std::string, Roundtrip> records_;
  std::unordered_map<std::string, DxfXclip> clips_;  ///< by extension dictionary
};

}  // namespace intaglio::drawing
