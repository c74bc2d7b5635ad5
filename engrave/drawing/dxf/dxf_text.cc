#include "engrave/drawing/dxf/dxf_text.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "engrave/drawing/pieces.h"
#include "engrave/drawing/utf8_characters.h"

namespace intaglio::drawing {
namespace {

constexpr std::size_t kMaxTextCharacters = 10'000;
constexpr double kMtextLineRatio = 5.0 / 3;  // of a line's height
constexpr double kMaxSlantDeg = 85;
constexpr std::array<std::string_view, 3> kTextTypes = {"TEXT", "ATTRIB", "MTEXT"};

/// The groups of an entity that say where its letters go.
struct TextGroups {
  DxfCommon common;
  std::string bytes;
  Vec3 first = Vec3::Zero(), second = Vec3::Zero();
  double height = 1, width_ratio = 1, rotation_deg = 0, slant_deg = 0;
  double box_width = 0, line_spacing = 1;
  double flags = 0, horizontal = 0, vertical = 0, attachment = 1, generation = 0;
  bool has_direction = false;
};

double* NumberFor(int code, bool is_mtext, std::string_view type, TextGroups& text) {
  switch (code) {
    case 10:
    case 20:
    case 30:
      return &text.first[code / 10 - 1];
    case 11:
    case 21:
    case 31:
      text.has_direction = true;
      return &text.second[code / 10 - 1];
    case 40:
      return &text.height;
    case 41:
      return is_mtext ? &text.box_width : &text.width_ratio;
    case 44:
      return is_mtext ? &text.line_spacing : nullptr;
    case 50:
      return &text.rotation_deg;
    case 51:
      return is_mtext ? nullptr : &text.slant_deg;
    case 70:
      return type == "ATTRIB" ? &text.flags : nullptr;
    case 71:
      return is_mtext ? &text.attachment : &text.generation;
    case 72:
      return is_mtext ? nullptr : &text.horizontal;
    case 73:
      return type == "TEXT" ? &text.vertical : nullptr;
    case 74:
      return type == "ATTRIB" ? &text.vertical : nullptr;
    default:
      return nullptr;
  }
}

bool ReadTextGroups(const DxfEntity& entity, DrawingBuilder& builder, TextGroups& text) {
  const bool is_mtext = entity.type == "MTEXT";
  DxfGroups groups(entity.groups, builder);
  DxfGroup group;
  while (groups.Next(group)) {
    if (group.code == 101) break;  // what follows are the columns of an MTEXT
    if (!TakeCommon(group, entity, builder, text.common)) return false;
    if (group.code == 1 || (is_mtext && group.code == 3)) text.bytes += group.raw;
    double* number = NumberFor(group.code, is_mtext, entity.type, text);
    if (number != nullptr && !DxfNumber(group, entity, builder, *number)) return false;
  }
  if (text.height <= 0) {
    return Refuse(entity, builder, "the height of a text must be positive", text.height);
  }
  if (text.width_ratio <= 0) {
    return Refuse(entity, builder, "the width of letters must be positive",
                  text.width_ratio);
  }
  return groups.good();
}

/// A line that is set: baseline y = 0 from x = 0, units of the file.
struct SetLineOfText {
  std::vector<Curve> curves;
  double width = 0;
  double height = 0;  ///< of the highest run
};

class TextSetter {
 public:
  TextSetter(const Typesetter& typesetter, double height)
      : typesetter_(typesetter), height_(height) {}

  /// False: a letter is in no font.
  bool Add(const DxfTextRun& run, SetLineOfText& line) const {
    const auto letters = typesetter_.SetLine(run.text, true);
    if (!letters) return false;
    const double height =
        run.height_ratio < 0 ? -run.height_ratio : run.height_ratio * height_;
    const double scale = height / typesetter_.cap_height();
    const Mat3 linear = Vec3(scale * run.width_ratio, scale, 1).asDiagonal();
    for (Curve curve : letters->curves) {
      for (Piece& piece : curve.pieces) Transform(linear, {line.width, 0, 0}, piece);
      line.curves.push_back(std::move(curve));
    }
    line.width += scale * run.width_ratio * letters->width;
    line.height = std::max(line.height, height);
    return true;
  }

  /// The width of a run alone; 0: a letter is in no font.
  double WidthOf(const DxfTextRun& run) const {
    SetLineOfText line;
    return Add(run, line) ? line.width : 0;
  }

 private:
  const Typesetter& typesetter_;
  double height_;
};

/// Breaks a line at its blanks so that none is wider than `width`, except for a word.
std::vector<DxfTextLine> Wrapped(const DxfTextLine& line, double width,
                                 const TextSetter& setter) {
  std::vector<DxfTextLine> lines(1);
  double used = 0;
  for (const DxfTextRun& run : line) {
    std::u32string_view rest = run.text;
    while (!rest.empty()) {
      const auto letters = rest.find_first_not_of(U' ');
      const auto end = letters == rest.npos ? rest.npos : rest.find(U' ', letters);
      DxfTextRun word{std::u32string(rest.substr(0, end)), run.height_ratio,
                      run.width_ratio};
      rest.remove_prefix(end == rest.npos ? rest.size() : end);
      double needed = setter.WidthOf(word);
      if (used > 0 && used + needed > width) {
        lines.emplace_back();
        used = 0;
        word.text.erase(0, std::min(word.text.find_first_not_of(U' '), word.text.size()));
        needed = setter.WidthOf(word);
      }
      used += needed;
      lines.back().push_back(std::move(word));
    }
  }
  return lines;
}

Mat3 TurnAboutZ(double angle_rad) {
  return Eigen::AngleAxisd(angle_rad, Vec3::UnitZ()).toRotationMatrix();
}

/// Moves the lines, one below the other, into the drawing.
void PlaceCurves(const Mat3& linear, const Vec3& offset, std::vector<Curve>& from,
                 std::vector<Curve>& to) {
  for (Curve& curve : from) {
    for (Piece& piece : curve.pieces) Transform(linear, offset, piece);
    to.push_back(std::move(curve));
  }
}

/// Turn and scale of a TEXT, and the share of its line left of its point. Codes 72: 0
/// left, 1 centre, 2 right, 3 aligned and 5 fit between two points, 4 middle.
struct TextPlace {
  Mat3 linear = Mat3::Identity();
  Vec3 at = Vec3::Zero();
};

TextPlace PlaceOfText(const TextGroups& text, const SetLineOfText& line) {
  constexpr double kDegree = std::numbers::pi / 180;
  const int horizontal = static_cast<int>(std::clamp(text.horizontal, 0.0, 5.0));
  const int vertical = static_cast<int>(std::clamp(text.vertical, 0.0, 3.0));
  const bool two_points = horizontal == 3 || horizontal == 5;
  Vec3 at = horizontal == 0 && vertical == 0 ? text.first : text.second;
  double angle_rad = text.rotation_deg * kDegree, along = 1, across = 1;
  if (two_points) {
    const Vec3 way = text.second - text.first;
    at = text.first;
    if (way.head<2>().norm() > 0) angle_rad = std::atan2(way.y(), way.x());
    if (line.width > 0) along = way.norm() / line.width;
    if (horizontal == 3) across = along;
  }
  const double left = horizontal == 1 || horizontal == 4 ? 0.5 : horizontal == 2 ? 1 : 0;
  // Without what hangs below the baseline, as tall as a capital.
  const double below = horizontal == 4 || vertical == 2 ? 0.5 : vertical == 3 ? 1 : 0;
  const auto generation = static_cast<unsigned>(std::clamp(text.generation, 0.0, 7.0));
  Mat3 shape = Vec3(along * ((generation & 2U) != 0 ? -1 : 1),
                    across * ((generation & 4U) != 0 ? -1 : 1), 1)
                   .asDiagonal();
  Mat3 slant = Mat3::Identity();
  slant(0, 1) =
      std::tan(std::clamp(text.slant_deg, -kMaxSlantDeg, kMaxSlantDeg) * kDegree);
  TextPlace place;
  place.linear = TurnAboutZ(angle_rad) * shape * slant;
  place.at = at - TurnAboutZ(angle_rad) * shape *
                      Vec3(left * line.width, below * line.height, 0);
  return place;
}

/// Lines of an MTEXT by its attachment: 1 2 3 top, 4 5 6 middle, 7 8 9 bottom; left,
/// centre, right.
std::vector<Curve> PlaceMtext(const TextGroups& text, std::vector<SetLineOfText> lines) {
  const int attachment = static_cast<int>(std::clamp(text.attachment, 1.0, 9.0)) - 1;
  std::vector<double> baselines;
  double y = 0;
  for (const SetLineOfText& line : lines) {
    const double height = line.height > 0 ? line.height : text.height;
    y -= baselines.empty() ? height : kMtextLineRatio * text.line_spacing * height;
    baselines.push_back(y);
  }
  const double lift = -y * 0.5 * (attachment / 3);
  double angle_rad = text.rotation_deg * std::numbers::pi / 180;
  if (text.has_direction && text.second.head<2>().norm() > 0) {
    angle_rad = std::atan2(text.second.y(), text.second.x());
  }
  const Mat3 turn = TurnAboutZ(angle_rad);
  std::vector<Curve> curves;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const Vec3 shift(-0.5 * (attachment % 3) * lines[i].width, baselines[i] + lift, 0);
    PlaceCurves(turn, text.first + turn * shift, lines[i].curves, curves);
  }
  return curves;
}

/// Empty: a letter is in no font.
std::vector<SetLineOfText> SetDxfLines(const std::vector<DxfTextLine>& lines,
                                       const TextSetter& setter) {
  std::vector<SetLineOfText> set;
  for (const DxfTextLine& line : lines) {
    set.emplace_back();
    for (const DxfTextRun& run : line) {
      if (!setter.Add(run, set.back())) return {};
    }
  }
  return set;
}

std::vector<DxfTextLine> LinesOf(const TextGroups& text, bool is_mtext,
                                 std::u32string_view letters, const TextSetter& setter) {
  if (!is_mtext) return {{{PlainDxfText(letters), 1, text.width_ratio}}};
  std::vector<DxfTextLine> lines;
  for (const DxfTextLine& line : DxfMtextLines(letters)) {
    if (text.box_width <= 0) {
      lines.push_back(line);
      continue;
    }
    for (DxfTextLine& part : Wrapped(line, text.box_width, setter)) {
      lines.push_back(std::move(part));
    }
  }
  return lines;
}

}  // namespace

bool IsDxfText(std::string_view type) {
  return std::ranges::find(kTextTypes, type) != kTextTypes.end();
}

bool SetDxfText(const DxfEntity& entity, const Typesetter& typesetter,
                DrawingBuilder& builder, DxfLettering& lettering) {
  TextGroups text;
  if (!ReadTextGroups(entity, builder, text)) return false;
  lettering.common = text.common;
  if ((static_cast<unsigned>(std::clamp(text.flags, 0.0, 255.0)) & 1U) != 0) {
    lettering.common.invisible = true;
  }
  const auto letters = CharactersOf(text.bytes);
  if (!letters || letters->size() > kMaxTextCharacters) {
    lettering.left_out =
        letters ? "text of more than 10000 letters" : "text not in UTF-8";
    return true;
  }
  const bool is_mtext = entity.type == "MTEXT";
  const TextSetter setter(typesetter, text.height);
  const auto lines = LinesOf(text, is_mtext, *letters, setter);
  std::vector<SetLineOfText> set = SetDxfLines(lines, setter);
  if (set.empty()) {
    lettering.left_out = "text with letters not in the font";
    return true;
  }
  if (is_mtext) {
    lettering.curves = PlaceMtext(text, std::move(set));
  } else {
    const TextPlace place = PlaceOfText(text, set.front());
    PlaceCurves(place.linear, place.at, set.front().curves, lettering.curves);
  }
  const Mat3 world = WorldFromEntity(text.common.extrusion);
  for (Curve& curve : lettering.curves) {
    for (Piece& piece : curve.pieces) Transform(world, Vec3::Zero(), piece);
  }
  return true;
}

}  // namespace intaglio::drawing
