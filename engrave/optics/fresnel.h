#pragma once

namespace intaglio::optics {

/// The share of the light's power that the block's top face reflects: from air (index 1)
/// into glass of index n >= 1, at normal incidence, 0..1: ((n - 1) / (n + 1))^2
/// (Fresnel).
double ReflectanceAtNormalIncidence(double refractive_index);

}  // namespace intaglio::optics
