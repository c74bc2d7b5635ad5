#include "engrave/drive/transfer.h"

#include "engrave/core/check.h"

namespace intaglio::drive {

std::size_t OrderOf(const Polynomial& polynomial) {
  std::size_t order = kMaxOrder;
  while (order > 0 && polynomial[order] == 0) --order;
  return order;
}

Polynomial Product(const Polynomial& f, const Polynomial& g) {
  const std::size_t of_f = OrderOf(f), of_g = OrderOf(g);
  Require(of_f + of_g <= kMaxOrder, "a product of order {} is above {}", of_f + of_g,
          kMaxOrder);
  Polynomial product = {};
  for (std::size_t i = 0; i <= of_f; ++i) {
    for (std::size_t k = 0; k <= of_g; ++k) product[i + k] += f[i] * g[k];
  }
  return product;
}

Polynomial Sum(const Polynomial& f, const Polynomial& g) {
  Polynomial sum = f;
  for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += g[i];
  return sum;
}

bool IsStable(const Polynomial& polynomial) {
  const std::size_t order = OrderOf(polynomial);
  // Two rows of the scheme, each of every other coefficient from the highest down.
  std::array<double, kMaxOrder + 2> row = {}, next = {};
  for (std::size_t k = 0; k <= order; ++k)
    (k % 2 == 0 ? row : next)[k / 2] = polynomial[order - k];
  for (std::size_t k = 0; k < order; ++k) {
    if (!(row[0] > 0) || !(next[0] > 0)) return false;
    std::array<double, kMaxOrder + 2> below = {};
    for (std::size_t j = 0; j + 1 < below.size(); ++j)
      below[j] = row[j + 1] - row[0] / next[0] * next[j + 1];
    row = next;
    next = below;
  }
  return row[0] > 0;
}

std::array<double, 4> SeriesOf(const Polynomial& f, const Polynomial& g) {
  std::array<double, 4> series = {};
  for (std::size_t k = 0; k < series.size(); ++k) {
    series[k] = f[k];
    for (std::size_t j = 1; j <= k; ++j) series[k] -= g[j] * series[k - j];
  }
  return series;
}

}  // namespace intaglio::drive
