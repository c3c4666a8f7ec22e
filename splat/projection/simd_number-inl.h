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

#include <hwy/contrib/math/math-inl.h>
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
HWY_INLINE SimdNumber exp(SimdNumber a) {
  return hwy::HWY_NAMESPACE::Exp(SimdNumber::Tag(), a.vector);
}
HWY_INLINE SimdNumber log(SimdNumber a) {
  return hwy::HWY_NAMESPACE::Log(SimdNumber::Tag(), a.vector);
}
HWY_INLINE SimdNumber log1p(SimdNumber a) {
  return hwy::HWY_NAMESPACE::Log1p(SimdNumber::Tag(), a.vector);
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

}  // namespace freegs::splat::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // FREEGS_SPLAT_PROJECTION_SIMD_NUMBER_INL_H_
