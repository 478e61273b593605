// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "lodestar/samples/counters.h"
#include "lodestar/samples/samples.h"

namespace lodestar::samples {

// Whether a sample may reach an estimator by itself: nothing if it may, else the first reason
// against it. Order of the tests: finite, in physical range, the sensor's own validity flag.
// Ranges are wide: they keep out what cannot be, not what is unlikely.

std::optional<Reason> refusal(const BodyRates& sample);       // |rate| <= 20 rad/s
std::optional<Reason> refusal(const LoadFactor& sample);      // |n| <= 30
std::optional<Reason> refusal(const MagneticField& sample);   // |b| <= 200 000 nT per axis
std::optional<Reason> refusal(const AirData& sample);         // see validity.cpp
std::optional<Reason> refusal(const SpecificForce& sample);   // |f| <= 700 m/s^2
std::optional<Reason> refusal(const GpsFix& sample);          // see validity.cpp
std::optional<Reason> refusal(const GpsObservables& sample);  // 0 to 16 satellites, 1e6..1e8 m
std::optional<Reason> refusal(const InsSolution& sample);     // see validity.cpp
std::optional<Reason> refusal(const SarMeasurement& sample);  // 0..1e6 m, |range rate| <= 5000 m/s
std::optional<Reason> refusal(const RadarAltitude& sample);   // -100..20 000 m

}  // namespace lodestar::samples
