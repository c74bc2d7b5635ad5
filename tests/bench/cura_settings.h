#pragma once

// The settings that CuraEngine 4.13 needs to reach its slices: the defaults of its own
// fdmprinter definition, which Debian packages elsewhere.

#include <array>

namespace intaglio::bench {

inline constexpr std::array kCuraSettings = {
    "adaptive_layer_height_enabled=false",
    "adhesion_type=brim",
    "alternate_carve_order=true",
    "alternate_extra_perimeter=false",
    "anti_overhang_mesh=false",
    "bottom_layers=6",
    "carve_multiple_volumes=true",
    "center_object=false",
    "conical_overhang_enabled=false",
    "cutting_mesh=false",
    "extruder_nr=0",
    "fill_outline_gaps=false",
    "hole_xy_offset=0",
    "infill_line_distance=2",
    "infill_mesh=false",
    "infill_mesh_order=0",
    "initial_bottom_layers=6",
    "initial_layer_line_width_factor=100.0",
    "magic_mesh_surface_mode=normal",
    "magic_spiralize=false",
    "material_shrinkage_percentage=100.0",
    "mesh_position_x=0",
    "mesh_position_y=0",
    "mesh_position_z=0",
    "mesh_rotation_matrix=[[1,0,0],[0,1,0],[0,0,1]]",
    "meshfix_extensive_stitching=false",
    "meshfix_keep_open_polygons=false",
    "meshfix_maximum_deviation=0.025",
    "meshfix_maximum_resolution=0.5",
    "meshfix_union_all=true",
    "meshfix_union_all_remove_holes=false",
    "minimum_polygon_circumference=1.0",
    "mold_enabled=false",
    "prime_tower_enable=false",
    "skin_line_width=0.4",
    "skin_no_small_gaps_heuristic=false",
    "skin_outline_count=1",
    "slicing_tolerance=middle",
    "support_enable=false",
    "support_mesh=false",
    "top_bottom_extruder_nr=-1",
    "top_layers=8",
    "top_skin_preshrink=1",
    "wall_0_extruder_nr=-1",
    "wall_0_inset=0.0",
    "wall_line_count=2",
    "wall_line_width_0=0.4",
    "wall_line_width_x=0.4",
    "wall_x_extruder_nr=-1",
    "wireframe_enabled=false",
    "xy_offset=0",
    "xy_offset_layer_0=0",
};

}  // namespace intaglio::bench
