#include "engrave/galvo/servo_lead.h"

#include "engrave/core/check.h"

namespace intaglio::galvo {

void LeadServo(double lag_s, double period_s, std::vector<Vec2>& places_mm) {
  Require(lag_s > 0 && period_s > 0, "a lag of {} s at a period of {} s", lag_s,
          period_s);
  if (places_mm.empty()) return;
  // (1 + tau s + tau^2/4 s^2) (1 + T/2 s + T^2/8 s^2), in units of the period.
  const double tau = lag_s / period_s;
  const double first = (tau + 0.5) / 2;
  const double second = tau * tau / 4 + tau / 2 + 0.125;
  Vec2 before = places_mm.front();
  for (std::size_t k = 0; k < places_mm.size(); ++k) {
    const Vec2 at = places_mm[k];
    const Vec2 after = k + 1 < places_mm.size() ? places_mm[k + 1] : at;
    places_mm[k] = at + first * (after - before) + second * (after - 2 * at + before);
    before = at;
  }
}

}  // namespace intaglio::galvo
