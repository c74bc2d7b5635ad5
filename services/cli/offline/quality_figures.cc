#include "services/cli/offline/quality_figures.h"

#include <fmt/format.h>

#include "engrave/core/check.h"
#include "engrave/core/counted.h"
#include "services/client/figure_text.h"
#include "services/client/warning_text.h"
#include "services/job/files/json_text.h"
#include "services/job/verdict/warnings.h"

namespace intaglio::cli {
namespace {

void Set(Vector3* to, const Vec3& from_mm) {
  to->set_x(from_mm.x());
  to->set_y(from_mm.y());
  to->set_z(from_mm.z());
}

void SetNearest(const proof::CloudQuality& quality, NearestDistanceFigures& figures) {
  const proof::NearestDistances& nearest = quality.nearest;
  figures.set_min_mm(nearest.smallest.distance_mm);
  figures.set_mean_mm(nearest.mean_mm);
  figures.set_variation_ratio(nearest.variation_ratio);
  figures.set_largest_mm(nearest.largest_mm);
  figures.set_doubled_count(nearest.doubled_count);
  figures.set_near_pair_count(nearest.near_pair_count);
  figures.set_near_point_count(nearest.near_point_count);
  figures.set_more_pairs(nearest.more_pairs);
  figures.set_min_scaled_mm(nearest.min_scaled.distance_mm);
  figures.set_first_point(nearest.min_scaled.first_point);
  figures.set_second_point(nearest.min_scaled.second_point);
  Set(figures.mutable_first_mm(), nearest.min_scaled.first_mm);
  Set(figures.mutable_second_mm(), nearest.min_scaled.second_mm);
  figures.set_bin_mm(quality.histogram.bin_mm);
  figures.mutable_bins()->Add(quality.histogram.counts.begin(),
                              quality.histogram.counts.end());
}

void SetSurface(const proof::SurfaceQuality& surface, SurfaceFigures& figures) {
  figures.set_triangle_count(surface.triangle_count);
  figures.set_area_mm2(surface.density.area_mm2);
  figures.set_uncovered_radius_mm(surface.uncovered.radius_mm);
  figures.set_uncovered_max_mm(surface.uncovered.upper_bound_mm);
  Set(figures.mutable_uncovered_place_mm(), surface.uncovered.place_mm);
  figures.set_greatest_distance_mm(surface.density.greatest_distance_mm);
  Set(figures.mutable_farthest_point_mm(), surface.farthest_mm);
  figures.set_on_surface_count(surface.density.on_surface_count);
  figures.set_greatest_on_surface_mm(surface.density.greatest_on_surface_mm);
  figures.set_points_per_mm2(surface.density.points_per_mm2);
  figures.set_density_ratio(surface.density_ratio);
  figures.set_patch_count(surface.density.patch_count);
  figures.set_variation_ratio(surface.density.variation_ratio);
  figures.set_empty_patch_count(surface.density.empty_patch_count);
  if (!surface.slices) return;
  HeightSliceFigures& slices = *figures.mutable_slices();
  slices.set_slice_mm(surface.slices->slice_mm);
  slices.set_slice_count(surface.slices->slice_count);
  slices.set_band_count(surface.slices->band_count);
  slices.set_smallest_ratio(surface.slices->smallest_ratio);
  slices.set_smallest_low_mm(surface.slices->smallest_low_mm);
}

void SetDensePlace(const proof::DensePlace& place, DensePlaceFigures& figures) {
  Set(figures.mutable_place_mm(), place.place_mm);
  figures.set_crack_count(place.cracks);
  figures.set_points_per_mm3(place.points_per_mm3);
  figures.set_crack_share_ratio(place.crack_share);
}

void SetCracks(const proof::CrackRisk& risk, const proof::QualityOptions& options,
               CrackRiskFigures& figures) {
  figures.set_crack_diameter_mm(options.crack_diameter_mm);
  figures.set_crack_length_mm(options.crack_length_mm);
  figures.set_ball_radius_mm(risk.ball_radius_mm);
  figures.set_max_share_ratio(risk.max_share);
  SetDensePlace(risk.densest, *figures.mutable_densest());
  figures.set_risky_count(risk.risky_count);
  for (const proof::DensePlace& place : risk.worst) {
    SetDensePlace(place, *figures.add_worst());
  }
}

std::string Percent(double ratio) { return fmt::format("{:.1f} %", 100 * ratio); }

/// Its lines are "subject text", the subjects in a column.
class Lines {
 public:
  template <typename... Args>
  void Add(std::string_view subject, fmt::format_string<Args...> words, Args&&... args) {
    text_ += fmt::format("{}{:<14}", text_.empty() ? "" : "\n", subject);
    text_ += fmt::format(words, std::forward<Args>(args)...);
  }
  std::string Take() { return std::move(text_); }

 private:
  std::string text_;
};

void AddNearest(const CloudQuality& quality, Lines& lines) {
  if (!quality.has_nearest()) return lines.Add("nearest", "none: one point");
  const NearestDistanceFigures& nearest = quality.nearest();
  lines.Add("nearest",
            "minimum {:.6f} mm, mean {:.4f} mm, largest {:.3f} mm; varies by {}",
            nearest.min_mm(), nearest.mean_mm(), nearest.largest_mm(),
            Percent(nearest.variation_ratio()));
  if (quality.height_ratio() != 1) {
    lines.Add("", "minimum {:.6f} mm with heights divided by {:g}",
              nearest.min_scaled_mm(), quality.height_ratio());
  }
  lines.Add("nearest pair", "points {} and {} of the file, at {}", nearest.first_point(),
            nearest.second_point(), PlaceText(nearest.first_mm()));
  lines.Add("too near", "{}{} {} below {:g} mm, {} at the place of another one",
            client::GroupedDigits(nearest.near_pair_count()),
            nearest.more_pairs() ? " or more" : "",
            NounFor(nearest.near_pair_count() + (nearest.more_pairs() ? 1 : 0), "pair"),
            quality.min_spacing_mm(),
            client::GroupedCount(nearest.doubled_count(), "point"));
}

void AddSurface(const CloudQuality& quality, Lines& lines) {
  const SurfaceFigures& surface = quality.surface();
  lines.Add("surface", "{:.1f} mm^2, {}", surface.area_mm2(),
            client::GroupedCount(surface.triangle_count(), "triangle"));
  lines.Add("uncovered", "largest disc {:.4f} mm in radius, {:.2f} spacings, at {}",
            surface.uncovered_radius_mm(),
            surface.uncovered_radius_mm() / quality.min_spacing_mm(),
            PlaceText(surface.uncovered_place_mm()));
  const std::uint64_t off = quality.point_count() - quality.nearest().doubled_count() -
                            surface.on_surface_count();
  lines.Add(
      "off surface",
      "maximum distance {:.3f} um, of the point at {}; {} ({}) {} farther than "
      "half a spacing, the others at most {:.3f} um",
      1000 * surface.greatest_distance_mm(), PlaceText(surface.farthest_point_mm()),
      client::GroupedCount(off, "point"),
      Percent(static_cast<double>(off) / static_cast<double>(quality.point_count())),
      IsOrAre(off), 1000 * surface.greatest_on_surface_mm());
  lines.Add("density",
            "{:.2f} points/mm^2, {} of the densest; varies by {} over {}, {} empty",
            surface.points_per_mm2(), Percent(surface.density_ratio()),
            Percent(surface.variation_ratio()),
            client::GroupedCount(surface.patch_count(), "patch", "patches"),
            client::GroupedDigits(surface.empty_patch_count()));
  if (!surface.has_slices()) return;
  const HeightSliceFigures& slices = surface.slices();
  lines.Add(
      "level slices",
      "of {:.3f} mm: at least {} of the points expected, between the heights {:.2f} "
      "and {:.2f} mm; below half of them in {} of {}",
      slices.slice_mm(), Percent(slices.smallest_ratio()), slices.smallest_low_mm(),
      slices.smallest_low_mm() + slices.slice_mm(),
      client::GroupedDigits(slices.band_count()),
      client::GroupedCount(slices.slice_count(), "slice"));
}

void AddSources(const CloudQuality& quality, Lines& lines) {
  constexpr int kMaxLines = 12;
  for (int i = 0; i < quality.sources_size(); ++i) {
    if (i == kMaxLines) {
      lines.Add("", "and {} more", quality.sources_size() - kMaxLines);
      break;
    }
    const SourceFigures& source = quality.sources(i);
    lines.Add(i == 0 ? "sources" : "", "model {}: {}, {}{}", source.source(),
              client::GroupedCount(source.point_count(), "point"),
              Percent(source.point_ratio()),
              source.has_surface_ratio()
                  ? ", on " + Percent(source.surface_ratio()) + " of the surface"
                  : "");
  }
}

void AddCracks(const CrackRiskFigures& cracks, Lines& lines) {
  const DensePlaceFigures& densest = cracks.densest();
  lines.Add("glass",
            "densest {:.0f} points/mm^3, cracks take {} of the volume, at {}; {} "
            "where it is above {}",
            densest.points_per_mm3(), Percent(densest.crack_share_ratio()),
            PlaceText(densest.place_mm()),
            client::GroupedCount(cracks.risky_count(), "point"),
            Percent(cracks.max_share_ratio()));
}

/// Rows of all single numbers, with the names of the messages that hold them.
void AddRows(const google::protobuf::Message& message, const std::string& prefix,
             std::string& rows) {
  using Field = google::protobuf::FieldDescriptor;
  const auto& reflection = *message.GetReflection();
  for (int i = 0; i < message.GetDescriptor()->field_count(); ++i) {
    const Field* field = message.GetDescriptor()->field(i);
    const std::string name = prefix + std::string(field->name());
    if (field->is_repeated()) continue;
    if (field->cpp_type() == Field::CPPTYPE_MESSAGE) {
      if (reflection.HasField(message, field)) {
        AddRows(reflection.GetMessage(message, field), name + ".", rows);
      }
    } else if (field->cpp_type() == Field::CPPTYPE_DOUBLE) {
      rows += fmt::format("{},{}\n", name, reflection.GetDouble(message, field));
    } else if (field->cpp_type() == Field::CPPTYPE_UINT64) {
      rows += fmt::format("{},{}\n", name, reflection.GetUInt64(message, field));
    } else if (field->cpp_type() == Field::CPPTYPE_UINT32) {
      rows += fmt::format("{},{}\n", name, reflection.GetUInt32(message, field));
    } else if (field->cpp_type() == Field::CPPTYPE_BOOL) {
      rows += fmt::format("{},{:d}\n", name, reflection.GetBool(message, field));
    }
  }
}

}  // namespace

std::string PlaceText(const Vector3& place_mm) {
  return fmt::format("({:.2f}, {:.2f}, {:.2f}) mm", place_mm.x(), place_mm.y(),
                     place_mm.z());
}

CloudQuality RecordOf(const proof::CloudQuality& quality,
                      const proof::QualityOptions& options) {
  CloudQuality record;
  record.set_point_count(quality.point_count);
  Set(record.mutable_min_mm(), quality.bounds_mm.min_mm);
  Set(record.mutable_max_mm(), quality.bounds_mm.max_mm);
  record.set_min_spacing_mm(options.min_spacing_mm);
  record.set_height_ratio(options.height_ratio);
  if (record.point_count() > 1) SetNearest(quality, *record.mutable_nearest());
  for (const proof::SourceShare& share : quality.sources) {
    SourceFigures& figures = *record.add_sources();
    figures.set_source(share.source);
    figures.set_point_count(share.point_count);
    figures.set_point_ratio(share.point_ratio);
    if (share.surface_ratio) figures.set_surface_ratio(*share.surface_ratio);
  }
  if (quality.surface) SetSurface(*quality.surface, *record.mutable_surface());
  if (quality.crack_risk) {
    SetCracks(*quality.crack_risk, options, *record.mutable_cracks());
  }
  AddTo(*record.mutable_warnings(), quality.warnings);
  record.set_keeps_spacing(quality.KeepsSpacing());
  return record;
}

std::string FiguresOf(const CloudQuality& quality) {
  Lines lines;
  lines.Add("points", "{}, {:.2f} x {:.2f} x {:.2f} mm",
            client::GroupedDigits(quality.point_count()),
            quality.max_mm().x() - quality.min_mm().x(),
            quality.max_mm().y() - quality.min_mm().y(),
            quality.max_mm().z() - quality.min_mm().z());
  AddNearest(quality, lines);
  if (quality.has_surface()) AddSurface(quality, lines);
  AddSources(quality, lines);
  if (quality.has_cracks()) AddCracks(quality.cracks(), lines);
  for (const Warning& warning : WarningsOf(quality.warnings())) {
    lines.Add(client::LabelOf(warning), "{}", warning.text);
  }
  return lines.Take();
}

std::string JsonOf(const CloudQuality& quality) {
  const auto json = JsonTextOf(quality);
  Require(json.has_value(), "the figures cannot be written: {}",
          json ? "" : json.error().message);
  return *json;
}

std::string CsvOf(const CloudQuality& quality) {
  std::string rows = "figure,value\n";
  AddRows(quality, "", rows);
  return rows;
}

}  // namespace intaglio::cli
