// SPDX-License-Identifier: Apache-2.0
#include "lodestar/earth/geomagnetic_model.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "lodestar/earth/wgs84.h"
#include "lodestar/math/rotation.h"

namespace lodestar::earth {
namespace {

using math::kDegree;
using math::kPi;

constexpr GeomagneticKind kKinds[] = {GeomagneticKind::kIgrf14, GeomagneticKind::kWmm2025};

// Field in E, in which it is one vector at a pole whatever the longitude.
Eigen::Vector3d field_E(GeomagneticModel& model, double lat, double lon, double h) {
  return C_NE(lat, lon).transpose() * model.field_N(lat, lon, h, 2026.3);
}

TEST(GeomagneticModel, PoleIsOneFieldFromEveryLongitude) {
  for (const GeomagneticKind kind : kKinds) {
    GeomagneticModel model(kind);
    for (const double pole : {-kPi / 2, kPi / 2}) {
      const Eigen::Vector3d expected = field_E(model, pole, 0.0, 5000.0);
      ASSERT_GT(expected.norm(), 50e3);
      for (double lon = -3.0; lon < 3.2; lon += 0.5) {
        EXPECT_LT((field_E(model, pole, lon, 5000.0) - expected).norm(), 1e-8);
      }
    }
  }
}

TEST(GeomagneticModel, FieldIsContinuousOverThePoles) {
  for (const GeomagneticKind kind : kKinds) {
    GeomagneticModel model(kind);
    for (const double side : {-1.0, 1.0}) {
      const double lat = side * (kPi / 2 - 1e-9);  // 6 mm from the pole, where the field changes by
      const Eigen::Vector3d here = field_E(model, lat, 0.7, 0.0);  // less than 4e-4 nT
      EXPECT_LT((field_E(model, lat, 0.7 + kPi, 0.0) - here).norm(), 4e-4);
      EXPECT_LT((field_E(model, side * kPi / 2, 0.0, 0.0) - here).norm(), 4e-4);
    }
  }
}

TEST(GeomagneticModel, FieldInFreeSpaceHasNeitherSourcesNorCurl) {
  const double d = 50.0;  // m; differences of second order leave 1e-7 of the gradient
  for (const GeomagneticKind kind : kKinds) {
    GeomagneticModel model(kind);
    for (const double lat : {-1.2, -0.3, 0.0, 0.9, 1.5}) {
      const Eigen::Vector3d centre = geodetic_to_ecef({lat, 0.8, 10e3});
      Eigen::Matrix3d gradient;
      for (int axis = 0; axis < 3; ++axis) {
        const Eigen::Vector3d step = d * Eigen::Vector3d::Unit(axis);
        const Geodetic ahead = ecef_to_geodetic(centre + step);
        const Geodetic behind = ecef_to_geodetic(centre - step);
        gradient.col(axis) = (field_E(model, ahead.lat, ahead.lon, ahead.h) -
                              field_E(model, behind.lat, behind.lon, behind.h)) /
                             (2.0 * d);
      }
      ASSERT_GT(gradient.norm(), 1e-2);  // nT/m
      EXPECT_NEAR(gradient.trace(), 0.0, 1e-8);
      EXPECT_LT((gradient - gradient.transpose()).norm(), 1e-8);
    }
  }
}

TEST(GeomagneticModel, FieldIsLinearInTimeBetweenEpochsAndContinuousAtThem) {
  GeomagneticModel model(GeomagneticKind::kIgrf14);
  const auto field = [&](double year) -> Eigen::Vector3d {
    return model.field_N(0.6, 0.2, 1000.0, year);
  };
  EXPECT_LT((field(2012.5) - 0.5 * (field(2010.0) + field(2015.0))).norm(), 1e-8);
  EXPECT_LT((field(2015.0 + 1e-9) - field(2015.0 - 1e-9)).norm(), 1e-6);
  EXPECT_GT((field(2014.0) - field(2013.0)).norm(), 1.0);
}

TEST(GeomagneticModel, ResultDoesNotDependOnWhatWasAskedBefore) {
  GeomagneticModel used(GeomagneticKind::kIgrf14);
  used.field_N(1.0, 2.0, 3.0, 1950.0);
  used.field_N(-0.2, 0.4, 3e3, 2029.0);
  GeomagneticModel fresh(GeomagneticKind::kIgrf14);
  EXPECT_EQ(used.field_N(0.7, 0.3, 4e3, 2012.8), fresh.field_N(0.7, 0.3, 4e3, 2012.8));
}

TEST(GeomagneticModel, OutsideItsEpochsTheNearestIsUsedAndSaid) {
  GeomagneticModel model(GeomagneticKind::kWmm2025);
  EXPECT_EQ(model.field_N(0.5, 0.5, 0.0, 2012.8), model.field_N(0.5, 0.5, 0.0, 2025.0));
  EXPECT_EQ(model.field_N(0.5, 0.5, 0.0, 2031.0), model.field_N(0.5, 0.5, 0.0, 2030.0));
  EXPECT_FALSE(model.validity(2024.99, 0.0).year);
  EXPECT_FALSE(model.validity(2030.01, 0.0).year);
  EXPECT_TRUE(model.validity(2025.0, 0.0).valid());
  EXPECT_TRUE(model.validity(2030.0, 0.0).valid());
}

TEST(GeomagneticModel, HeightsItWasNotMadeForAreSaid) {
  const GeomagneticModel model(GeomagneticKind::kIgrf14);
  EXPECT_TRUE(model.validity(2012.8, -1000.0).valid());
  EXPECT_TRUE(model.validity(2012.8, 600e3).valid());
  EXPECT_FALSE(model.validity(2012.8, -1001.0).height);
  EXPECT_FALSE(model.validity(2012.8, 601e3).valid());
}

TEST(GeomagneticModel, WhatIsNotANumberIsNeitherValidNorHidden) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  GeomagneticModel model(GeomagneticKind::kIgrf14);
  EXPECT_FALSE(model.validity(nan, 0.0).year);
  EXPECT_FALSE(model.validity(2020.0, nan).height);
  EXPECT_TRUE(model.field_N(0.5, 0.5, 0.0, nan).array().isNaN().all());
  EXPECT_TRUE(model.field_N(nan, 0.5, 0.0, 2020.0).array().isNaN().any());
  EXPECT_TRUE(model.field_N(0.5, 0.5, 0.0, 2020.0).allFinite());
}

}  // namespace
}  // namespace lodestar::earth
