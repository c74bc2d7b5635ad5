#include "engrave/render/letters/stroke_letters.h"

#include <array>

namespace intaglio::render {
namespace {

constexpr std::array<const char*, 95> kAscii = {
    "",                                       // blank
    "l0m0g l0d0d",                            // !
    "l0m0k l2m2k",                            // "
    "l1d2m l4d5m l0g6g l0j6j",                // #
    "s5k5m0m0i5h5d0d0f l2c3n",                // $
    "l0d6m c0j2j2m0m c4d6d6g4g",              // %
    "s6d1j1m4m4j0g0d4d6h",                    // &
    "l0m0k",                                  // '
    "s2n0k0e2b",                              // (
    "s0n2k2e0b",                              // )
    "l2i2m l0j4l l0l4j",                      // *
    "l0h4h l2f2j",                            // +
    "l1d0b",                                  // ,
    "l0h3h",                                  // -
    "l0d0d",                                  // .
    "l0c4m",                                  // /
    "c0d5d5m0m",                              // 0
    "l1k3m3d l1d5d",                          // 1
    "s0k0m5m5i3g0d l0d5d",                    // 2
    "s0k0m5m5i2i s2i5i5d0d0f",                // 3
    "l4d4m0g5g",                              // 4
    "l5m1m0i s0i2k5j5d1d0e",                  // 5
    "s5l4m0m0g c0d5d5j0j",                    // 6
    "l0m5m2d",                                // 7
    "c0d5d5i0i c0i5i5m0m",                    // 8
    "s0e1d5d5j c0g5g5m0m",                    // 9
    "l0d0d l0i0i",                            // :
    "l1i1i l1d0b",                            // ;
    "l4j0h4f",                                // <
    "l0g4g l0i4i",                            // =
    "l0j4h0f",                                // >
    "s0k0m4m4i2i2g l2d2d",                    // ?
    "c2f4f4j2j s4j4f6f6m0m0d5d",              // @
    "l0d3m6d l1g5g",                          // A
    "l3d0d0m3m s3m5m5i3i l0i3i s3i5i5d3d",    // B
    "s5k5m0m0d5d5f",                          // C
    "l2d0d0m2m s2m5m5d2d",                    // D
    "l5d0d0m5m l0i4i",                        // E
    "l0d0m5m l0i4i",                          // F
    "s5k5m0m0d5d5h l3h5h",                    // G
    "l0d0m l5d5m l0i5i",                      // H
    "l0d2d l1d1m l0m2m",                      // I
    "l4m4g s4g4d0d0g",                        // J
    "l0d0m l5m0g l2i5d",                      // K
    "l0m0d5d",                                // L
    "l0d0m3g6m6d",                            // M
    "l0d0m5d5m",                              // N
    "c0d6d6m0m",                              // O
    "l0d0m3m s3m5m5h3h l3h0h",                // P
    "c0d6d6m0m l4f6d",                        // Q
    "l0d0m3m s3m5m5h3h l3h0h l2h5d",          // R
    "s5k5m0m0i5h5d0d0f",                      // S
    "l0m6m l3m3d",                            // T
    "l0m0g s0g0d5d5g l5g5m",                  // U
    "l0m3d6m",                                // V
    "l0m2d4k6d8m",                            // W
    "l0d5m l0m5d",                            // X
    "l0m3h6m l3h3d",                          // Y
    "l0m5m0d5d",                              // Z
    "l2n0n0b2b",                              // [
    "l0m4c",                                  // backslash
    "l0n2n2b0b",                              // ]
    "l0k2m4k",                                // ^
    "l0c5c",                                  // _
    "l0m1k",                                  // `
    "c0d4d4j0j l4d4j",                        // a
    "c0d4d4j0j l0d0m",                        // b
    "s4i4j0j0d4d4e",                          // c
    "c0d4d4j0j l4d4m",                        // d
    "l0g4g s4g4j0j0d3d4e",                    // e
    "s3m1m1k l1k1d l0j3j",                    // f
    "c0d4d4j0j l4j4c s4c4a0a0b",              // g
    "l0d0m s0h0j4j4g l4g4d",                  // h
    "l0d0j l0l0l",                            // i
    "l2j2c s2c2a0a l2l2l",                    // j
    "l0d0m l4j0f l1g4d",                      // k
    "l0m0f s0f0d2d",                          // l
    "l0d0j s0h0j3j3g l3g3d s3h3j6j6g l6g6d",  // m
    "l0d0j s0h0j4j4g l4g4d",                  // n
    "c0d4d4j0j",                              // o
    "c0d4d4j0j l0j0a",                        // p
    "c0d4d4j0j l4j4a",                        // q
    "l0d0j s0h0j3j",                          // r
    "s4i4j0j0g4g4d0d0e",                      // s
    "l1l1f s1f1d3d l0j3j",                    // t
    "l0j0g s0g0d4d4f l4d4j",                  // u
    "l0j2d4j",                                // v
    "l0j1d3i5d6j",                            // w
    "l0d4j l0j4d",                            // x
    "l0j2d l4j1a",                            // y
    "l0j4j0d4d",                              // z
    "s3n1n1h0h s0h1h1b3b",                    // {
    "l0n0b",                                  // |
    "s0n2n2h3h s3h2h2b0b",                    // }
    "s0h1j3f4h",                              // ~
};

}  // namespace

const char* StrokesOf(char32_t sign) {
  if (sign >= U' ' && sign <= U'~') return kAscii[sign - U' '];
  switch (sign) {
    case U'µ':
    case U'μ':
      return "l0j0a s0g0d4d4f l4d4j";
    case U'°':
      return "c0j3j3m0m";
    case U'±':
      return "l0i4i l2g2k l0e4e";
    case U'×':
      return "l0f4j l0j4f";
    case U'·':
      return "l0h0h";
    case U'–':
      return "l0h5h";
    case U'²':
      return "s0l0m2m2l0i l0i2i";
    case U'ß':
      return "l0d0k s0k0m4m4i2i s2i5i5d2d";
    case U'æ':
      return "c0d3d3j0j l3g7g s7g7j3j3d6d";
    case U'œ':
      return "c0d4d4j0j l4g8g s8g8j4j4d7d";
    case U'Æ':
      return "l0d4m7m l4m4d7d l1g4g l4i6i";
    case U'ı':
      return "l0d0j";
    case U'³':
      return "s0m2m2k1k s1k2k2i0i";
    case U'\uFFFD':
      return "l0d4d4m0m0d";
    default:
      return nullptr;
  }
}

}  // namespace intaglio::render
