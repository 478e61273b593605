// SPDX-License-Identifier: Apache-2.0
#include "lodestar/sahrs/calibration_record.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <cstring>

#include "lodestar/math/crc32.h"

namespace lodestar::sahrs::smdu {
namespace {

constexpr std::size_t kChecksumSize = 4;
constexpr double kLargestBias = 200e3;  // nT, the range of the detector
constexpr double kLargestElement = 1.0;

template <class Word>
void put(std::string& bytes, Word word) {
  for (std::size_t i = 0; i < sizeof(Word); ++i) {
    bytes.push_back(static_cast<char>(static_cast<unsigned char>(word >> (8 * i))));
  }
}

void put_double(std::string& bytes, double value) {
  std::uint64_t word = 0;
  std::memcpy(&word, &value, sizeof word);
  put(bytes, word);
}

/// Takes words off the front. The caller has checked the size.
class Reader {
 public:
  explicit Reader(std::string_view bytes) : bytes_(bytes) {}

  std::string_view text(std::size_t size) {
    const std::string_view front = bytes_.substr(0, size);
    bytes_.remove_prefix(size);
    return front;
  }

  template <class Word>
  Word word() {
    Word value = 0;
    const std::string_view front = text(sizeof(Word));
    for (std::size_t i = sizeof(Word); i-- > 0;) {
      value = static_cast<Word>(value << 8 | static_cast<unsigned char>(front[i]));
    }
    return value;
  }

  double real() {
    const auto bits = word<std::uint64_t>();
    double value = 0.0;
    std::memcpy(&value, &bits, sizeof value);
    return value;
  }

 private:
  std::string_view bytes_;
};

bool plausible(const Record& record) {
  const StateVector& x = record.calibration.x;
  const StateMatrix& P = record.calibration.P;
  if (!x.allFinite() || !P.allFinite() || !std::isfinite(record.epoch_year)) return false;
  if (x.head<kBias.size>().cwiseAbs().maxCoeff() > kLargestBias) return false;
  if (x.tail<kCalibrationStates - kBias.size>().cwiseAbs().maxCoeff() > kLargestElement) {
    return false;
  }
  // A covariance, scaled so that nT and numbers without unit go together.
  if (P.diagonal().minCoeff() <= 0.0) return false;
  const StateVector unit = P.diagonal().cwiseSqrt().cwiseInverse();
  if (!unit.allFinite()) return false;
  const StateMatrix scaled = unit.asDiagonal() * P * unit.asDiagonal();
  const StateMatrix lifted = scaled + 1e-9 * StateMatrix::Identity();
  return lifted.llt().info() == Eigen::Success;
}

}  // namespace

std::string encode(const Record& record) {
  std::string bytes(kRecordMagic);
  put(bytes, kRecordVersion);
  put(bytes, static_cast<std::uint32_t>(record.source));
  std::string airframe = record.airframe.substr(0, kLongestAirframe);
  airframe.resize(kLongestAirframe + 1, '\0');
  bytes += airframe;
  put(bytes, static_cast<std::uint64_t>(record.time_us));
  put_double(bytes, record.epoch_year);
  for (const double value : record.calibration.x) put_double(bytes, value);
  for (int i = 0; i < kCalibrationStates; ++i) {
    for (int j = 0; j <= i; ++j) put_double(bytes, record.calibration.P(i, j));
  }
  put(bytes, math::crc32(bytes));
  return bytes;
}

std::variant<Record, Refusal> decode(std::string_view bytes, std::string_view airframe) {
  if (bytes.substr(0, kRecordMagic.size()) != kRecordMagic) return Refusal::kForeign;
  if (bytes.size() < kRecordMagic.size() + sizeof kRecordVersion) return Refusal::kSize;
  Reader reader(bytes);
  reader.text(kRecordMagic.size());
  const auto version = reader.word<std::uint32_t>();
  if (version < kRecordVersion) return Refusal::kOldVersion;
  if (version > kRecordVersion) return Refusal::kNewVersion;
  if (bytes.size() != kRecordSize) return Refusal::kSize;
  const std::size_t body = kRecordSize - kChecksumSize;
  if (Reader(bytes.substr(body)).word<std::uint32_t>() != math::crc32(bytes.substr(0, body))) {
    return Refusal::kChecksum;
  }
  Record record;
  const auto source = reader.word<std::uint32_t>();
  if (source > static_cast<std::uint32_t>(Source::kGroundSwing)) return Refusal::kImplausible;
  record.source = static_cast<Source>(source);
  const std::string_view padded = reader.text(kLongestAirframe + 1);
  record.airframe = std::string(padded.substr(0, padded.find('\0')));
  if (record.airframe != airframe) return Refusal::kAirframe;
  record.time_us = static_cast<std::int64_t>(reader.word<std::uint64_t>());
  record.epoch_year = reader.real();
  for (double& value : record.calibration.x) value = reader.real();
  for (int i = 0; i < kCalibrationStates; ++i) {
    for (int j = 0; j <= i; ++j) {
      record.calibration.P(i, j) = reader.real();
      record.calibration.P(j, i) = record.calibration.P(i, j);
    }
  }
  if (!plausible(record)) return Refusal::kImplausible;
  return record;
}

}  // namespace lodestar::sahrs::smdu
