#pragma once
/// The normal distribution in single precision and without a branch: loops over lanes become vector instructions.
#include <bit>
#include <cstdint>

namespace ninedot {

/// \param x  <= 0 [1] \return  exp(x): 2^n times a polynomial on [-ln2/2, ln2/2]; relative error below 3e-7. Below -80
/// it is exp(-80). Coefficients: Cody & Waite's reduction with the Taylor polynomial of degree 6.
inline float exp_of_negative(float x) noexcept {
  x = x > -80.0F ? x : -80.0F;
  const float n = static_cast<float>(static_cast<std::int32_t>(x * 1.44269504F - 0.5F));
  const float r = x - n * 0.693359375F + n * 2.12194440e-4F;
  const float p =
      1 + r * (1 + r * (0.5F + r * (0.166666667F + r * (0.0416666667F + r * (0.00833333333F + r * 0.00138888889F)))));
  const std::int32_t exponent = (static_cast<std::int32_t>(n) + 127) << 23;
  return p * std::bit_cast<float>(exponent);
}

/// The standard normal density and its integral from |z| on [1].
struct NormalTail {
  float density, tail;  ///< [1]
};
/// Abramowitz & Stegun, "Handbook of Mathematical Functions", 26.2.17; error below 7.5e-8. \param z  in sigmas [1]
inline NormalTail normal_tail(float z) noexcept {
  const float density = 0.39894228F * exp_of_negative(-0.5F * z * z);
  const float k = 1 / (1 + 0.2316419F * (z > 0 ? z : -z));
  return {
      density,
      density * k * (0.319381530F + k * (-0.356563782F + k * (1.781477937F + k * (-1.821255978F + k * 1.330274429F))))};
}

}  // namespace ninedot
