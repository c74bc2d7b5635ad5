#pragma once

namespace intaglio::optics {

/// The share of the light's power that the block's top face reflects: from air (index 1)
/// into glass of index n >= 1, at normal incidence, 0..1: ((n - 1) / (n + 1))^2
/// (Fresnel).
double ReflectanceAtNormalIncidence(double refractive_index);

/// The same of unpolarized light at an angle of incidence in air, 0..pi/2 rad from the
/// normal: the mean of both polarizations (Fresnel). It grows with the angle to 1.
double ReflectanceAtAngle(double refractive_index, double incidence_rad);

}  // namespace intaglio::optics
