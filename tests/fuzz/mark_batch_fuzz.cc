// Batches of marks as a faulty sender may fill them, one after another: refused, with
// what came before as it was, or marks that fit together.

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

#include "engrave/core/check.h"
#include "services/platform/bus/samples.h"
#include "services/platform/host/stage/mark_batch.h"

namespace {

using namespace intaglio;

class Input {
 public:
  Input(const std::uint8_t* bytes, std::size_t count) : bytes_(bytes), count_(count) {}
  bool empty() const { return count_ == 0; }
  std::uint8_t Next() {
    if (empty()) return 0;
    --count_;
    return *bytes_++;
  }
  /// Any double that eight bytes can be, or mostly a small number.
  double NextDouble() {
    if (Next() % 8 != 0) return static_cast<std::int8_t>(Next()) / 8.0;
    std::uint64_t bits = 0;
    for (int i = 0; i < 8; ++i) bits = bits << 8 | Next();
    double value = 0;
    std::memcpy(&value, &bits, sizeof(value));
    return value;
  }
  template <typename T, typename Make>
  std::vector<T> List(std::size_t wanted, Make make) {
    // Mostly as long as it should be.
    if (Next() % 16 == 0) wanted = Next() % 8;
    std::vector<T> list(wanted);
    for (T& one : list) one = make();
    return list;
  }

 private:
  const std::uint8_t* bytes_;
  std::size_t count_;
};

void TryNext(Input& input, mark::MarkSet& set) {
  const auto next_double = [&] { return input.NextDouble(); };
  const auto next_byte = [&] { return input.Next(); };
  const std::size_t marks = input.Next() % 6;
  std::size_t places = 0;
  const auto counts = input.List<std::uint32_t>(marks, [&] {
    const std::uint32_t count = input.Next() % 64 == 0 ? 0xfffffff0 : input.Next() % 5;
    places += count;
    return count;
  });
  places = std::min<std::size_t>(places, 64);
  const std::string name = "pen";
  const auto pens = input.List<intaglio_MarkPen>(set.marks.empty() ? 2 : 0, [&] {
    intaglio_MarkPen pen{};
    pen.name = bus::Borrow(name);
    pen.speed_mm_s = input.NextDouble();
    pen.power_ratio = input.NextDouble();
    pen.frequency_hz = input.NextDouble();
    pen.pass_count = input.Next();
    pen.depth_mm = input.NextDouble();
    pen.plunge_mm_s = input.NextDouble();
    return pen;
  });
  const auto pen =
      input.List<std::uint32_t>(marks, [&] { return std::uint32_t{input.Next()} % 3; });
  const auto closed = input.List<std::uint8_t>(marks, next_byte);
  const auto web = input.List<double>(marks, next_double);
  const auto x = input.List<double>(places, next_double);
  const auto y = input.List<double>(places, next_double);
  const auto bulge = input.List<double>(places, next_double);
  const auto dark =
      input.List<std::uint8_t>(input.Next() % 2 == 0 ? 0 : places, next_byte);
  intaglio_MarkBatch batch{};
  batch.first_mark = set.marks.size();
  bus::Borrow(batch.pens, pens);
  bus::Borrow(batch.pen, pen);
  bus::Borrow(batch.closed, closed);
  bus::Borrow(batch.web_mm, web);
  bus::Borrow(batch.place_count, counts);
  bus::Borrow(batch.x_mm, x);
  bus::Borrow(batch.y_mm, y);
  bus::Borrow(batch.bulge, bulge);
  bus::Borrow(batch.dark, dark);
  const std::size_t had = set.marks.size(), had_pens = set.pens.size();
  const auto taken = host::AppendMarks(batch, set);
  Require(mark::CheckMarks(set).has_value() || set.marks.empty(), "impossible marks");
  if (taken) {
    Require(set.marks.size() == had + pen.size(), "another number of marks");
    return;
  }
  Require(!taken.error().message.empty(), "an error without a sentence");
  Require(set.marks.size() == had && set.pens.size() == had_pens, "half a batch");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  Input input(data, std::min<std::size_t>(size, 4096));
  mark::MarkSet set;
  while (!input.empty()) TryNext(input, set);
  return 0;
}
