// SPDX-License-Identifier: BSD-3-Clause
// A SIMD vector of floats with the operators of a number, for templates that
// also run on doubles and on the automatic derivatives of Ceres.

// Compiled anew for each instruction set: see hwy/highway.h on -inl.h files.
#if defined(FREEGS_SPLAT_PROJECTION_SIMD_NUMBER_INL_H_) == \
    defined(HWY_TARGET_TOGGLE)
#ifdef FREEGS_SPLAT_PROJECTION_SIMD_NUMBER_INL_H_
#undef FREEGS_SPLAT_PROJECTION_SIMD_NUMBER_INL_H_
#else
#define FREEGS_SPLAT_PROJECTION_SIMD_NUMBER_INL_H_
#endif

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace freegs::splat::HWY_NAMESPACE {

// A constructor that is not declared here is not compiled for the instruction
// set, and GCC does not let it call what is.
struct SimdMask {
  using Mask =
      hwy::HWY_NAMESPACE::Mask<hwy::HWY_NAMESPACE::CappedTag<float, 16>>;

  SimdMask() = default;
  HWY_INLINE SimdMask(Mask m) : mask(m) {}

  Mask mask;
};

// Up to 16 floats.
struct SimdNumber {
  using Tag = hwy::HWY_NAMESPACE::CappedTag<float, 16>;
  using Vector = hwy::HWY_NAMESPACE::Vec<Tag>;

  SimdNumber() = default;
  HWY_INLINE SimdNumber(Vector v) : vector(v) {}
  HWY_INLINE explicit SimdNumber(float value)
      : vector(hwy::HWY_NAMESPACE::Set(Tag(), value)) {}
  HWY_INLINE explicit SimdNumber(double value)
      : SimdNumber(static_cast<float>(value)) {}
  HWY_INLINE explicit SimdNumber(int value)
      : SimdNumber(static_cast<float>(value)) {}

  HWY_INLINE SimdNumber& operator+=(SimdNumber other) {
    vector = hwy::HWY_NAMESPACE::Add(vector, other.vector);
    return *this;
  }
  HWY_INLINE SimdNumber& operator-=(SimdNumber other) {
    vector = hwy::HWY_NAMESPACE::Sub(vector, other.vector);
    return *this;
  }

  Vector vector;
};

HWY_INLINE SimdNumber operator+(SimdNumber a, SimdNumber b) {
  return hwy::HWY_NAMESPACE::Add(a.vector, b.vector);
}
HWY_INLINE SimdNumber operator-(SimdNumber a, SimdNumber b) {
  return hwy::HWY_NAMESPACE::Sub(a.vector, b.vector);
}
HWY_INLINE SimdNumber operator-(SimdNumber a) {
  return hwy::HWY_NAMESPACE::Neg(a.vector);
}
HWY_INLINE SimdNumber operator*(SimdNumber a, SimdNumber b) {
  return hwy::HWY_NAMESPACE::Mul(a.vector, b.vector);
}
HWY_INLINE SimdNumber operator/(SimdNumber a, SimdNumber b) {
  return hwy::HWY_NAMESPACE::Div(a.vector, b.vector);
}
HWY_INLINE SimdMask operator>(SimdNumber a, SimdNumber b) {
  return {hwy::HWY_NAMESPACE::Gt(a.vector, b.vector)};
}
HWY_INLINE SimdMask And(SimdMask a, SimdMask b) {
  return {hwy::HWY_NAMESPACE::And(a.mask, b.mask)};
}
HWY_INLINE SimdNumber Select(SimdMask mask, SimdNumber yes, SimdNumber no) {
  return hwy::HWY_NAMESPACE::IfThenElse(mask.mask, yes.vector, no.vector);
}
HWY_INLINE SimdNumber sqrt(SimdNumber a) {
  return hwy::HWY_NAMESPACE::Sqrt(a.vector);
}
HWY_INLINE SimdNumber ceil(SimdNumber a) {
  return hwy::HWY_NAMESPACE::Ceil(a.vector);
}
HWY_INLINE SimdNumber Min(SimdNumber a, SimdNumber b) {
  return hwy::HWY_NAMESPACE::Min(a.vector, b.vector);
}
HWY_INLINE SimdNumber Max(SimdNumber a, SimdNumber b) {
  return hwy::HWY_NAMESPACE::Max(a.vector, b.vector);
}

// The functions below use no fused multiplication and addition, so they give
// the same bytes with every instruction set. Those of Highway do not.

// ln 2 in two parts. The first is 355 / 512, whose product with a whole number
// below 2^15 is exact.
inline constexpr float kLn2High = 0.693359375f;
inline constexpr float kLn2Low = -2.12194440e-4f;

// e^x with a relative error below 3e-7. x is kept within [-87, 88], where the
// result and its inverse are finite. NaN stays NaN.
HWY_INLINE SimdNumber exp(SimdNumber x) {
  namespace hn = hwy::HWY_NAMESPACE;
  const SimdNumber::Tag d;
  const hn::RebindToSigned<SimdNumber::Tag> di;
  const SimdNumber least(-87.0f), most(88.0f);
  x = Select(x > most, most, x);
  x = Select(least > x, least, x);
  // e^x = 2^n e^f with |f| <= ln(2) / 2, where eight terms of the series of e^f
  // are enough.
  const SimdNumber n = hn::Round((x * SimdNumber(1.4426950408889634f)).vector);
  const SimdNumber f = (x - n * SimdNumber(kLn2High)) - n * SimdNumber(kLn2Low);
  SimdNumber sum(1.0f / 5040);
  for (const float inverse_factorial :
       {1.0f / 720, 1.0f / 120, 1.0f / 24, 1.0f / 6, 0.5f, 1.0f, 1.0f}) {
    sum = sum * f + SimdNumber(inverse_factorial);
  }
  const auto exponent = hn::Add(hn::ConvertTo(di, n.vector), hn::Set(di, 127));
  return sum * SimdNumber(hn::BitCast(d, hn::ShiftLeft<23>(exponent)));
}

// ln x for x in [1.2e-38, 3.4e38], with a relative error below 3e-7. Any value
// for other x.
HWY_INLINE SimdNumber log(SimdNumber x) {
  namespace hn = hwy::HWY_NAMESPACE;
  const SimdNumber::Tag d;
  const hn::RebindToSigned<SimdNumber::Tag> di;
  // x = 2^n m with m from sqrt(1/2), whose bits these are, to sqrt(2).
  const auto sqrt_half = hn::Set(di, 0x3f3504f3);
  const auto bits = hn::Sub(hn::BitCast(di, x.vector), sqrt_half);
  const SimdNumber n = hn::ConvertTo(d, hn::ShiftRight<23>(bits));
  const SimdNumber m = hn::BitCast(
      d, hn::Add(hn::And(bits, hn::Set(di, 0x007fffff)), sqrt_half));
  // ln m = 2 artanh(s) = 2 (s + s^3 / 3 + s^5 / 5 + ...) with |s| < 0.172.
  const SimdNumber one(1.0f);
  const SimdNumber s = (m - one) / (m + one);
  const SimdNumber s2 = s * s;
  SimdNumber sum(2.0f / 9);
  for (const float factor : {2.0f / 7, 2.0f / 5, 2.0f / 3}) {
    sum = sum * s2 + SimdNumber(factor);
  }
  const SimdNumber small = s * s2 * sum + n * SimdNumber(kLn2Low);
  return (small + (s + s)) + n * SimdNumber(kLn2High);
}

// ln(1 + x) for x in [0, 3.4e38], with a relative error below 6e-7. NaN stays
// NaN.
HWY_INLINE SimdNumber log1p(SimdNumber x) {
  // What 1 + x lost by rounding is made up for by a factor.
  const SimdNumber one(1.0f);
  const SimdNumber sum = one + x;
  const SimdNumber rest = sum - one;
  return Select(rest > SimdNumber(0.0f), log(sum) * (x / rest), x);
}

}  // namespace freegs::splat::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // FREEGS_SPLAT_PROJECTION_SIMD_NUMBER_INL_H_
