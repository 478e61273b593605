// SPDX-License-Identifier: Apache-2.0
#include "lodestar/sahrs/calibration_record.h"

#include <gtest/gtest.h>

#include <limits>
#include <random>

#include "lodestar/math/crc32.h"

namespace lodestar::sahrs::smdu {
namespace {

Record record(unsigned seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> gaussian;
  Record r;
  r.airframe = "39-101";
  r.time_us = 3'000'000'001 + seed;
  r.epoch_year = 2026.5;
  r.source = static_cast<Source>(seed % 2);
  StateMatrix A;
  for (double& value : A.reshaped()) value = gaussian(random);
  const StateMatrix squared = A * A.transpose() + StateMatrix::Identity();
  StateVector unit = StateVector::Constant(1e-4);
  unit.head<3>().setConstant(20.0);
  r.calibration.P = unit.asDiagonal() * squared * unit.asDiagonal();
  r.calibration.P = (0.5 * (r.calibration.P + r.calibration.P.transpose())).eval();
  for (int i = 0; i < kCalibrationStates; ++i)
    r.calibration.x(i) = 10.0 * unit(i) * gaussian(random);
  return r;
}

std::string refusal(std::string_view bytes, std::string_view airframe = "39-101") {
  const auto decoded = decode(bytes, airframe);
  const Refusal* refused = std::get_if<Refusal>(&decoded);
  return refused == nullptr ? "accepted" : name(*refused);
}

/// With the right checksum again.
std::string sealed(std::string bytes) {
  bytes.resize(kRecordSize - 4);
  const std::uint32_t crc = math::crc32(bytes);
  for (int i = 0; i < 4; ++i) bytes.push_back(static_cast<char>(crc >> (8 * i)));
  return bytes;
}

TEST(CalibrationRecord, ComesBackBitForBit) {
  for (unsigned seed = 0; seed < 50; ++seed) {
    const Record r = record(seed);
    const std::string bytes = encode(r);
    ASSERT_EQ(bytes.size(), kRecordSize);
    const auto decoded = decode(bytes, r.airframe);
    const Record& back = std::get<Record>(decoded);
    EXPECT_EQ(back.airframe, r.airframe);
    EXPECT_EQ(back.time_us, r.time_us);
    EXPECT_EQ(back.epoch_year, r.epoch_year);
    EXPECT_EQ(back.source, r.source);
    EXPECT_EQ(back.calibration.x, r.calibration.x);
    EXPECT_EQ(back.calibration.P, r.calibration.P);
  }
}

TEST(CalibrationRecord, RefusesEveryFlippedBit) {
  const std::string good = encode(record(1));
  for (std::size_t bit = 0; bit < 8 * good.size(); ++bit) {
    std::string bytes = good;
    bytes[bit / 8] = static_cast<char>(bytes[bit / 8] ^ (1 << (bit % 8)));
    EXPECT_NE(refusal(bytes), "accepted") << bit;
  }
  std::string bytes = good;
  bytes[300] = static_cast<char>(bytes[300] ^ 1);
  EXPECT_EQ(refusal(bytes), "damaged: its checksum is wrong");
}

TEST(CalibrationRecord, RefusesEveryOtherLength) {
  const std::string good = encode(record(1));
  for (std::size_t size = 0; size < good.size(); ++size) {
    const std::string what = refusal(std::string_view(good).substr(0, size));
    EXPECT_EQ(what, size < 8 ? "not a calibration file" : "torn: its size is wrong") << size;
  }
  EXPECT_EQ(refusal(good + "x"), "torn: its size is wrong");
}

TEST(CalibrationRecord, RefusesOtherVersionsAirframesAndFilesByName) {
  std::string bytes = encode(record(1));
  EXPECT_EQ(refusal(bytes, "39-102"), "of another airframe");
  EXPECT_EQ(refusal(bytes, ""), "of another airframe");
  bytes[8] = 0;
  EXPECT_EQ(refusal(sealed(bytes)), "written in an older format");
  bytes[8] = 2;
  EXPECT_EQ(refusal(sealed(bytes)), "written in a newer format");
  EXPECT_EQ(refusal("[smdu_calibration]\nbias_nT = [1, 2, 3]\n"), "not a calibration file");
  EXPECT_EQ(refusal(""), "not a calibration file");
}

TEST(CalibrationRecord, RefusesNumbersThatCannotBe) {
  const char* expected = "its numbers cannot be a calibration's";
  Record r = record(1);
  r.calibration.x(0) = 3e5;
  EXPECT_EQ(refusal(encode(r)), expected);
  r = record(1);
  r.calibration.x(4) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(refusal(encode(r)), expected);
  r = record(1);
  r.calibration.P(5, 5) = -r.calibration.P(5, 5);
  EXPECT_EQ(refusal(encode(r)), expected);
  r = record(1);
  r.calibration.P(1, 0) = 2.0 * std::sqrt(r.calibration.P(0, 0) * r.calibration.P(1, 1));
  EXPECT_EQ(refusal(encode(r)), expected);
}

TEST(CalibrationRecord, SurvivesAnyBytes) {
  std::mt19937_64 random(5);
  for (int i = 0; i < 20000; ++i) {
    std::string bytes = encode(record(1));
    for (int k = 0; k < 8; ++k) bytes[random() % bytes.size()] = static_cast<char>(random());
    bytes.replace(0, 12, encode(record(1)).substr(0, 12));
    const auto decoded = decode(sealed(bytes), "39-101");  // past the checksum
    if (const Record* r = std::get_if<Record>(&decoded)) {
      EXPECT_TRUE(r->calibration.x.allFinite());
      EXPECT_TRUE(r->calibration.P.allFinite());
    }
  }
}

}  // namespace
}  // namespace lodestar::sahrs::smdu
