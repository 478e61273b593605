// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>

namespace lodestar::earth {

enum class GeomagneticKind { kIgrf14, kWmm2025 };

/// Names of the kinds, by their value.
inline constexpr const char* kGeomagneticNames[] = {"igrf14", "wmm2025"};

/// Whether a model is meant for a date and a height.
struct ModelValidity {
  bool year = false;    // within the model's epochs; else the field is that of the nearest epoch
  bool height = false;  // within the heights it was made for; else the field is extrapolated

  bool valid() const { return year && height; }
};

/// The Earth's main magnetic field: the gradient of a potential in spherical harmonics whose
/// coefficients are linear in time between epochs (SAHRS paper §3.2; Linköping thesis eq. 2.13,
/// whose sum over m has to start at 0). IGRF-14: degree 13, 1900 to 2030. WMM2025: degree 12, 2025
/// to 2030. The Legendre functions are built up in degree at fixed order, the stable direction, and
/// divided by the sine of the colatitude throughout, so that the poles are points like any other.
class GeomagneticModel {
 public:
  explicit GeomagneticModel(GeomagneticKind kind);

  ModelValidity validity(double decimal_year, double h) const;
  double first_year() const { return years_[0]; }
  double last_year() const { return years_[epochs_ - 1]; }
  double min_height() const { return -1000.0; }      // m
  double max_height() const { return max_height_; }  // m: WMM2025's report 850 km, IGRF-14 600 km

  /// Field (nT) in N at geodetic `lat`, `lon` (rad), `h` (m above the ellipsoid). Not const: the
  /// coefficients of the last `decimal_year` are kept.
  Eigen::Vector3d field_N(double lat, double lon, double h, double decimal_year);

 private:
  static constexpr int kMaxDegree = 13;

  // One degree n and order m of the expansion. With root(n) = sqrt(n^2 - m^2), the Schmidt
  // semi-normalised functions P_n of x = cos(colatitude), s its sine, obey
  //   root(n+1) P_{n+1} = (2n + 1) x P_n - root(n) P_{n-1}
  //   s dP_n/d(colatitude) = n x P_n - root(n) P_{n-1}
  struct Term {
    Eigen::Vector2d gh = Eigen::Vector2d::Zero();  // nT, Gauss coefficients g and h
    double n = 0.0;
    double root = 0.0;
    double forward = 0.0;   // (2n + 1) / root(n+1)
    double backward = 0.0;  // root(n) / root(n+1)
  };
  using Order = std::array<Term, kMaxDegree + 1>;  // by n; those below m are not used

  // Where the field is wanted, in geocentric terms.
  struct Place {
    double x;      // cosine of the colatitude
    double s;      // sine of the colatitude
    double ratio;  // reference radius over radius
  };

  void set_factors();
  void set_year(double year);
  Eigen::Vector3d zonal_field(const Place& place) const;
  Eigen::Vector3d field_geocentric(const Place& place, double lon) const;

  int degree_;
  int epochs_;
  const double* years_;                            // [epochs]
  const double* coefficients_;                     // nT, [epochs][degree (degree + 2)]
  double max_height_;                              // m
  double year_;                                    // of the Gauss coefficients in orders_
  std::array<Order, kMaxDegree + 1> orders_;       // by m
  std::array<double, kMaxDegree + 1> diagonal_{};  // P_m of order m / (s P_{m-1} of order m-1)
};

}  // namespace lodestar::earth
